// Geometry and connectivity of triangle surfaces.
#pragma once
#include "vci/types.hpp"
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

/// For each vertex the vertices that share an edge with it, ascending.
std::vector<std::vector<int>> vertex_neighbours(const Triangles& triangles, int vertex_count);

} // namespace vci
