// Candidate triangles near a point: FCL's dynamic tree of axis-aligned boxes.
#pragma once
#include "vci/types.hpp"
#include <memory>

namespace vci {

class BroadPhase {
public:
  /// Boxes round the triangles at positions x.
  BroadPhase(const Triangles& triangles, const Vectors& x);
  ~BroadPhase();
  BroadPhase(BroadPhase&&) noexcept;
  BroadPhase& operator=(BroadPhase&&) noexcept;

  /// Fits the boxes to new positions.
  void update(const Triangles& triangles, const Vectors& x);
  /// Triangles whose box comes within `reach` (mm) of p along each axis, in ascending order.
  void near(const Vec3& p, double reach, std::vector<int>& found) const;

private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

} // namespace vci
