// Branches that were cut off or occluded near their origin, and that have no axis of their own.
#pragma once
#include "centreline/tree.hpp"

namespace anatomy {

/// A stub that counts as wall. Its line goes from the nearest axis to the stub's tip.
struct ClosedStub {
  std::size_t branch = 0; ///< of that axis
  double s = 0;           ///< mm along it
  Vec3 from, tip;

  /// Whether p is nearer to the stub's line than to the axis at `on_axis`, in the stub's direction.
  bool contains(const Vec3& p, const Vec3& on_axis) const;
};

/// The tips that are at least two inscribed radii from every axis. Nearer ones are bumps of the wall.
std::vector<ClosedStub> closed_stubs(const std::vector<Branch>& branches, const std::vector<Vec3>& tips);

} // namespace anatomy
