// The projection of a vertex onto a surface along its interpolated normals.
#pragma once
#include "vci/mechanics/system.hpp"

namespace vci {

struct SurfaceProjection {
  int triangle = -1;               ///< number in the target body; -1: none
  Vec3 weights = Vec3::Zero();     ///< barycentric weights of the projection
  double distance_squared = 1e300; ///< mm^2, between the vertex and its projection
  bool along_normals = false;      ///< the normal at the projection leads to the vertex; false: a near point only
};

/// Unit normal at a place of a triangle, interpolated between the normals at the corners.
/// @param weights barycentric coordinates of the place
/// @param unit_normals unit normals of all vertices
Vec3 interpolated_normal(const Triangle& t, const Vec3& weights, const Vectors& unit_normals);

/// Projects p (mm) along the surface's normals onto the triangle that p met last. If this succeeds, no search among all
/// candidates is needed. Returns false if the projection lies outside this triangle, or 0.1 mm or more from p.
bool follow_projection(const Vec3& p, int triangle, const System& system, const Vectors& unit_normals,
                       const Body& target, SurfaceProjection& projection);

/// Projects p onto the edge of a triangle at a sharp fold. There the normals of neither side may lead to p. The point
/// of the surface closest to p would jump between the sides from step to step, and the contact would not converge. So
/// the projection along the normals, which lies outside the triangle, is moved onto the triangle's edge. Returns false
/// if that projection lies far outside the triangle, or the edge 0.1 mm or more from p.
bool project_onto_edge(const Vec3& p, int triangle, const System& system, const Vectors& unit_normals,
                       const Body& target, SurfaceProjection& projection);

/// Projects p along the interpolated normals. If this fails for all candidates near p, the result is the closest point.
/// @param candidates numbers of triangles of `target`
/// @param distance set to the distance from p to the closest point, mm
SurfaceProjection project_onto(const Vec3& p, const std::vector<int>& candidates, const System& system,
                               const Vectors& unit_normals, const Body& target, double& distance);

} // namespace vci
