// Closes loops of border edges by triangles. The same input always gives the same result.
#pragma once
#include "repair/loops.hpp"

namespace anatomy {

/// Closes the hole at a border halfedge by the triangulation that bends least. Returns the new faces; none if there is
/// no triangulation. A hole of more than 250 edges is filled in parts.
std::vector<Face> fill_hole(Mesh& mesh, Halfedge border);

/// Divides edges of the border loop at vertices of the same loop that lie on them (within `tolerance`, mm). The edges
/// on the two sides of a gap without width can then be stitched. Returns the number of new points. Loops of more than
/// 250 edges are not changed.
std::size_t divide_border(Mesh& mesh, Halfedge border, double tolerance);

/// Closes a plane loop by its constrained Delaunay triangulation, whose triangles are refined to the size of the rim's
/// edges. Returns the new faces; none if the loop cannot be closed.
std::vector<Face> cap_loop(Mesh& mesh, const Loop& loop);

} // namespace anatomy
