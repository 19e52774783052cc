// Branches that were cut off or occluded near their origin, and that have no axis of their own.
#pragma once
#include "centreline/tree.hpp"

namespace anatomy {

/// A stub that counts as wall. It is represented by the line from the nearest branch's axis to the stub's tip.
struct ClosedStub {
  std::size_t branch = 0; ///< index of the nearest branch
  double s = 0;           ///< arc length (mm) of the point `from` on that branch's axis
  Vec3 from, tip;         ///< mm, ends of the stub's line: on the axis, and at the tip

  /// Whether p is nearer to the stub's line than to the axis point `on_axis`, and lies on the stub's side of that
  /// point.
  bool contains(const Vec3& p, const Vec3& on_axis) const;
};

/// The stubs of those `tips` (mm) that are more than two inscribed radii from the nearest axis. Nearer tips are bumps
/// of the wall.
std::vector<ClosedStub> closed_stubs(const std::vector<Branch>& branches, const std::vector<Vec3>& tips);

} // namespace anatomy
