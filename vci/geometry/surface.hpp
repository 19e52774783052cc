// Geometry and connectivity of triangle surfaces.
#pragma once
#include "vci/linalg/types.hpp"
#include <Eigen/Geometry>

namespace vci {

/// An interior edge (e0, e1) and the two triangles beside it, (e0, e1, w0) and (e1, e0, w1), which face the same side.
struct InteriorEdge {
  int e0, e1, w0, w1;
  double rest_length; ///< mm
};

/// Edges with exactly two triangles that face the same side. Boundary and non-manifold edges are left out.
std::vector<InteriorEdge> interior_edges(const Triangles& triangles, const Vectors& points);

/// For each vertex whether it lies on an edge that has only one triangle.
std::vector<char> boundary_vertices(const Triangles& triangles, int vertex_count);

/// Area vector (mm^2) of a triangle: its normal times its area.
inline Vec3 area_vector(const Triangle& t, const Vectors& x) {
  return 0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
}

/// Area vector (mm^2) of each vertex in [first, first + count): a third of those of the triangles round it.
Vectors vertex_area_vectors(const Triangles& triangles, const Vectors& x, int first, int count);

/// Distance (mm), along the normals, from a point of a triangle to the smooth surface through the triangle's corners.
/// It is the sum over the sides of w_i w_j (n_j - n_i) . (x_j - x_i) / 2. For the middle of a chord of length l in a
/// circle of radius R this is l^2 / (8 R). The sagitta is positive if the surface is convex as seen from outside.
/// @param weights barycentric coordinates of the point
/// @param unit_normals unit normals of the vertices
double sagitta(const Triangle& t, const Vec3& weights, const Vectors& x, const Vectors& unit_normals);
/// An upper bound (mm) for the size of the sagitta at any point of the triangle.
double largest_sagitta(const Triangle& t, const Vectors& x, const Vectors& unit_normals);

/// Winding number of a closed, outward-oriented surface round a point: 1 inside, 0 outside. It is defined even if the
/// surface intersects itself. Each open end changes it by the share of the full solid angle that the end fills as seen
/// from the point (Jacobson et al., ACM Trans. Graph. 32(4), 2013).
double winding_number(const Vec3& p, const Triangles& triangles, const Vectors& x);

/// For each vertex the vertices that share an edge with it, ascending.
std::vector<std::vector<int>> vertex_neighbours(const Triangles& triangles, int vertex_count);

} // namespace vci
