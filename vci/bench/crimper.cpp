#include "vci/bench/crimper.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace vci {

double Crimper::depth(const Vec3& p) const {
  return std::max(0.0, std::hypot(p[0], p[1]) - radius_);
}

double Crimper::energy(const Vectors& x) const {
  double sum = 0;
  for (int v : vertices_)
    sum += 0.5 * stiffness_ * depth(x[v]) * depth(x[v]);
  return sum;
}

void Crimper::evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool) const {
  for (std::size_t k = 0; k < vertices_.size(); ++k) {
    const Vec3& p = x[vertices_[k]];
    const double d = depth(p);
    if (d <= 0)
      continue;
    const Vec3 outward = Vec3(p[0], p[1], 0).normalized(), tangential = Vec3::UnitZ().cross(outward);
    force[vertices_[k]] -= stiffness_ * d * outward;
    if (stiffness)
      stiffness->block(slots_[k]) +=
          stiffness_ * (outward * outward.transpose() + d / (radius_ + d) * tangential * tangential.transpose());
  }
}

double Crimper::total_force(const Vectors& x) const {
  double sum = 0;
  for (int v : vertices_)
    sum += stiffness_ * depth(x[v]);
  return sum;
}

} // namespace vci
