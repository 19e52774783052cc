// Small handles of a closed surface, as noise leaves where it is contoured.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// Cuts out and closes every handle that lies within a patch of the surface with one rim, of at most 0.35 mean radii
/// of the vessel round a place on the handle: a tunnel through the wall's roughness, not vessels that fuse. Appends
/// what was done. The closed mesh must be one component without removed elements; larger handles stay.
void remove_small_handles(Mesh& mesh, std::vector<Repair>& repairs);

} // namespace anatomy
