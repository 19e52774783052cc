// The projection of a vertex onto a surface along its interpolated normals.
#pragma once
#include "vci/mechanics/system.hpp"

namespace vci {

struct SurfaceProjection {
  int triangle = -1;
  Vec3 weights = Vec3::Zero();
  double distance_squared = 1e300; ///< mm^2
  bool along_normals = false;      ///< the point lies over the triangle along its interpolated normals
};

/// @param units unit normals of the vertices
Vec3 interpolated_normal(const Triangle& t, const Vec3& weights, const Vectors& units);

/// Projects onto the triangle of the last search, which saves a new search among all candidates. Returns false if the
/// projection has left this triangle, or is no longer near.
bool follow_projection(const Vec3& p, int triangle, const System& system, const Vectors& units, const Body& target,
                       SurfaceProjection& projection);

/// Projects onto the edge of the triangle, as near as possible to the point along the normals. At a sharp fold a vertex
/// may lie over neither side along the normals. The closest point then jumps between the sides, and a contact there
/// would find no balance. Returns false if the point along the normals lies far beyond the edge.
bool stay_on_edge(const Vec3& p, int triangle, const System& system, const Vectors& units, const Body& target,
                  SurfaceProjection& projection);

/// The projection along the interpolated normals if a triangle near by has such a point, else the closest point.
/// @param distance set to the distance of the closest point, mm
SurfaceProjection project_onto(const Vec3& p, const std::vector<int>& candidates, const System& system,
                               const Vectors& units, const Body& target, double& distance);

} // namespace vci
