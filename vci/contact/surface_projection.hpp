// The projection of a vertex onto a surface along its interpolated normals.
#pragma once
#include "vci/mechanics/system.hpp"

namespace vci {

struct SurfaceProjection {
  int triangle = -1;
  Vec3 weights = Vec3::Zero();
  double distance_squared = 1e300;
};

/// @param units unit normals of the vertices
Vec3 interpolated_normal(const Triangle& t, const Vec3& weights, const Vectors& units);

/// The projection onto the triangle where it was last. Returns false where it no longer lies there, or not near. It
/// saves the search among all candidates.
bool follow_projection(const Vec3& p, int triangle, const System& system, const Vectors& units, const Body& target,
                       SurfaceProjection& projection);

/// The projection along the interpolated normals where a triangle near by has such a point, else the closest point.
/// @param distance set to that of the closest point, mm
SurfaceProjection project_onto(const Vec3& p, const std::vector<int>& candidates, const System& system,
                               const Vectors& units, const Body& target, double& distance);

} // namespace vci
