// Triangles over a closed loop of border edges, the same ones for the same input.
#pragma once
#include "repair/loops.hpp"

namespace anatomy {

/// Closes the hole behind a border halfedge by the triangulation of least bending; its faces, none if there is no such
/// triangulation.
std::vector<Face> filled(Mesh& mesh, Halfedge border);

/// Divides the loop's edges where points of the loop lie on them (within `tolerance`, mm), so that these can be
/// stitched to the edges of the other side; how many. Loops of more than 250 edges are left as they are.
std::size_t divided(Mesh& mesh, Halfedge border, double tolerance);

/// Closes a plane loop by its constrained Delaunay triangulation, refined to the density of the rim; its faces, none if
/// the loop cannot be closed.
std::vector<Face> capped(Mesh& mesh, const Loop& loop);

} // namespace anatomy
