// Removes small handles of a closed surface, which come from noise in the contoured image.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// Cuts out every small handle and closes the wall there. A small handle is a tunnel through the wall's roughness. It
/// lies in a patch of the surface with a single rim. The patch reaches at most 0.35 mean radii of the vessel from a
/// place on the handle. Larger handles, such as those of fused vessels, stay. Reports the change in `repairs`. The
/// closed mesh must be one component without removed elements.
void remove_small_handles(Mesh& mesh, std::vector<Repair>& repairs);

} // namespace anatomy
