// Widens the narrow triangles that remeshing by length alone leaves at carinas and where the edge length changes.
#pragma once
#include "core/wall_tree.hpp"

namespace anatomy {

/// Raises the corners below `wanted` degrees of wall triangles that touch no cap. Round each, the worst first, edges
/// are flipped, collapsed or split, and vertices are moved on `wall`, the wall of the smooth `surface`. The change that
/// raises the smallest corner of the neighbourhood most is kept. So no corner outside caps and rims falls below the
/// smallest one at the start. If narrow corners remain, this is repeated up to `passes` times, since their neighbours
/// have changed. Tags are kept; the mesh is compact on return.
/// @param careful do not keep a change after which the neighbourhood crosses itself, as some do on a rough wall
void widen_corners(Mesh& mesh, const Mesh& surface, const WallTree& wall, double wanted, int passes = 3,
                   bool careful = false);

} // namespace anatomy
