// Where a surface crosses itself.
#pragma once
#include "vci/linalg/types.hpp"

namespace vci {

struct Crossings {
  int pairs = 0;             ///< pairs of triangles that cross each other and share no vertex
  Vec3 first = Vec3::Zero(); ///< a vertex of the first pair, mm
};

/// The crossings of some of a surface's triangles with any of its triangles.
/// @param triangles indices of points x (mm)
/// @param some numbers of the triangles to look at, ascending
Crossings self_crossings(const Triangles& triangles, const std::vector<int>& some, const Vectors& x);

} // namespace vci
