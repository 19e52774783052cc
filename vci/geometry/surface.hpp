// Geometry and connectivity of triangle surfaces.
#pragma once
#include "vci/linalg/types.hpp"
#include <Eigen/Geometry>

namespace vci {

/// An interior edge and the two triangles beside it: (e0, e1, w0) and (e1, e0, w1), oriented alike.
struct EdgePair {
  int e0, e1, w0, w1;
  double rest_length; ///< mm
};

/// Edges with exactly two triangles of opposite orientation; others (boundary, non-manifold) are left out.
std::vector<EdgePair> interior_edges(const Triangles& triangles, const Vectors& points);

/// True for vertices on an edge that has only one triangle.
std::vector<char> boundary_vertices(const Triangles& triangles, int vertex_count);

/// Area vector (mm^2) of a triangle: its normal times its area.
inline Vec3 area_vector(const Triangle& t, const Vectors& x) {
  return 0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
}

/// A third of the area vectors of the triangles round each vertex, for vertices [first, first + count).
Vectors vertex_area_vectors(const Triangles& triangles, const Vectors& x, int first, int count);

/// Distance (mm) from a point of a triangle to the smooth surface through its corners, along the normals. It is the sum
/// over the sides of w_i w_j (n_j - n_i) . (x_j - x_i) / 2. In the middle of a chord of a circle this is l^2 / (8 R).
/// It is positive if the surface is convex as seen from outside.
/// @param weights barycentric coordinates of the point
/// @param units unit normals of the vertices
double sagitta(const Triangle& t, const Vec3& weights, const Vectors& x, const Vectors& units);
/// An upper bound of the sagitta's size anywhere on the triangle, mm.
double largest_sagitta(const Triangle& t, const Vectors& x, const Vectors& units);

/// Winding number of a closed, outward-oriented surface round a point: 1 inside, 0 outside. It also works if the
/// surface intersects itself. An open end reduces it by the end's solid angle. (Jacobson and others, ACM Trans. Graph.
/// 32(4), 2013)
double winding_number(const Vec3& p, const Triangles& triangles, const Vectors& x);

/// For each vertex the vertices that share an edge with it, ascending.
std::vector<std::vector<int>> vertex_neighbours(const Triangles& triangles, int vertex_count);

} // namespace vci
