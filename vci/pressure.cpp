#include "vci/pressure.hpp"
#include "vci/surface.hpp"

#include <Eigen/Geometry>

namespace vci {

double Pressure::energy(const Vectors& x) const {
  double volume = 0;
  for (const Triangle& t : triangles_)
    volume += x[t[0]].dot(x[t[1]].cross(x[t[2]])) / 6.0;
  return -pressure_ * volume;
}

void Pressure::evaluate(const Vectors& x, Vectors& force, BlockMatrix*, bool) const {
  for (const Triangle& t : triangles_) {
    const Vec3 share = pressure_ / 3.0 * area_vector(t, x);
    for (int v : t)
      force[v] += share;
  }
}

} // namespace vci
