// Adds straight flow extensions at the ends.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// Returns a copy of the closed, tagged mesh with straight extensions. The cap of ends[e] moves out along its normal by
/// `radii[e]` times the end's radius; 0 leaves it in place. `ends` get their new centres and `extension`. The mesh must
/// have no removed elements. Throws InputError if an extension meets another part of the surface.
Mesh extended(const Mesh& mesh, std::vector<End>& ends, const std::vector<double>& radii);

} // namespace anatomy
