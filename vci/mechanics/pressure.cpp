#include "vci/mechanics/pressure.hpp"

#include <Eigen/Geometry>

namespace vci {

double Pressure::energy(const Vectors& x) const {
  double volume = 0;
  for (const Triangle& t : triangles_)
    volume += x[t[0]].dot(x[t[1]].cross(x[t[2]])) / 6.0;
  return -pressure_ * volume;
}

void Pressure::evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const {
  for (const Triangle& t : triangles_) {
    const Vec3 share = pressure_ / 3.0 * area_vector(t, x);
    for (int v : t)
      force[v] += share;
  }
  if (!stiffness)
    return;
  // dF(e0)/dx(e1) is p/6 times the cross product with the line between the two opposite vertices
  const double sixth = (exact ? 1.0 : 0.5) * pressure_ / 6.0;
  for (std::size_t k = 0; k < edges_.size(); ++k) {
    const Vec3 w = sixth * (x[edges_[k].w0] - x[edges_[k].w1]);
    Mat3 cross;
    cross << 0, -w[2], w[1], w[2], 0, -w[0], -w[1], w[0], 0;
    if (edges_[k].e0 < edges_[k].e1)
      stiffness->block(slots_[k]) += cross;
    else
      stiffness->block(slots_[k]) -= cross; // the stored block is that of (e1, e0), the transpose
  }
}

void Pressure::declare_stencils(BlockPattern& pattern) const {
  for (const InteriorEdge& e : edges_)
    pattern.add(std::array<int, 2>{e.e0, e.e1});
}

void Pressure::locate_blocks(const BlockMatrix& matrix) {
  slots_.clear();
  for (const InteriorEdge& e : edges_)
    slots_.push_back(matrix.slot(std::min(e.e0, e.e1), std::max(e.e0, e.e1)));
}

} // namespace vci
