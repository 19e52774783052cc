// Triangulates closed loops of border edges, always with the same result for the same input.
#pragma once
#include "repair/loops.hpp"

namespace anatomy {

/// Closes the hole behind a border halfedge by the triangulation of least bending. Returns its faces; none if there is
/// no triangulation.
std::vector<Face> filled(Mesh& mesh, Halfedge border);

/// Divides the loop's edges at points of the loop that lie on them (within `tolerance`, mm), so that they can be
/// stitched to the edges of the other side. Returns the number of new points. Loops of more than 250 edges are not
/// changed.
std::size_t divided(Mesh& mesh, Halfedge border, double tolerance);

/// Closes a plane loop by its constrained Delaunay triangulation, refined to the density of the rim. Returns its faces;
/// none if the loop cannot be closed.
std::vector<Face> capped(Mesh& mesh, const Loop& loop);

} // namespace anatomy
