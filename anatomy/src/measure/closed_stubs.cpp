#include "measure/closed_stubs.hpp"
#include <algorithm>

namespace anatomy {
namespace {

constexpr double far_off = 2; // a tip farther from the axis (in inscribed radii) is a stub's: it stands out by a radius

} // namespace

bool ClosedStub::contains(const Vec3& p, const Vec3& on_axis) const {
  const Vec3 line = tip - from;
  const double along = std::clamp((p - from).dot(line) / line.squaredNorm(), 0.0, 1.0);
  return (p - from - along * line).norm() < (p - on_axis).norm() && (p - on_axis).dot(line) > 0;
}

std::vector<ClosedStub> closed_stubs(const std::vector<Branch>& branches, const std::vector<Vec3>& tips) {
  std::vector<ClosedStub> stubs;
  for (const Vec3& tip : tips) {
    const NearestAxis near = nearest_axis(branches, tip);
    const Branch& branch = branches[near.branch];
    if (near.distance > far_off * branch.radius[near.sample])
      stubs.push_back({near.branch, branch.s[near.sample], branch.x[near.sample], tip});
  }
  return stubs;
}

} // namespace anatomy
