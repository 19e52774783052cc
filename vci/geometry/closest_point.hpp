// Closest points on triangles.
#pragma once
#include "vci/linalg/types.hpp"

namespace vci {

struct ClosestPoint {
  Vec3 weights;            ///< barycentric coordinates in the triangle
  double distance_squared; ///< mm^2
};

/// Closest point to p on triangle (a, b, c), by Voronoi regions (Ericson, Real-Time Collision Detection, 5.1.5).
ClosestPoint closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

} // namespace vci
