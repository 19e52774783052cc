// Widens the narrow triangles that remeshing by length alone leaves at carinas and where the edge length changes.
#pragma once
#include "core/wall_tree.hpp"

namespace anatomy {

/// Widens the angles below `wanted` degrees of wall triangles that touch no cap, the narrowest triangle first. Round a
/// triangle an edge is flipped, collapsed or split, and vertices are moved on `wall`, the wall of the smooth `surface`.
/// Several such changes are tried. The one that widens the smallest angle of the neighbourhood most is kept. So no
/// angle outside caps and rims falls below the smallest one at the start. Up to `passes` passes are made, since an
/// angle may give way once its neighbours have changed. Tags are kept; the mesh has no removed elements on return.
/// @param careful reject a change after which the neighbourhood crosses itself, as happens on a rough wall
void widen_angles(Mesh& mesh, const Mesh& surface, const WallTree& wall, double wanted, int passes = 3,
                  bool careful = false);

} // namespace anatomy
