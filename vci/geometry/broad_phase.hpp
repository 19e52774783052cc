// Candidate triangles near a point: FCL's dynamic tree of axis-aligned boxes.
#pragma once
#include "vci/linalg/types.hpp"
#include <memory>

namespace vci {

struct NearTriangle {
  int triangle;
  double distance; ///< mm
  Vec3 weights;    ///< barycentric weights of the closest point
};

class BroadPhase {
public:
  /// Builds boxes round the triangles at positions x (mm).
  BroadPhase(const Triangles& triangles, const Vectors& x);
  ~BroadPhase();
  BroadPhase(BroadPhase&&) noexcept;
  BroadPhase& operator=(BroadPhase&&) noexcept;

  /// Takes new positions. The boxes are fitted again only after a vertex has moved by more than 0.1 mm. Until then a
  /// search also enters boxes that are further away by the largest displacement, so that it misses no triangle.
  void update(const Triangles& triangles, const Vectors& x);
  /// Finds the triangles within `reach` (mm) of p that are at most `slack` (mm) further away than the nearest. They are
  /// sorted by their numbers.
  /// @param triangles, x as given to the last update
  /// @param guess a triangle that may be near, or -1; a good guess shortens the search and does not change its result
  void find_near(const Vec3& p, const Triangles& triangles, const Vectors& x, double reach, double slack, int guess,
                 std::vector<NearTriangle>& hits) const;

private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

} // namespace vci
