// Straight flow extensions at the ends.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// A copy of the closed, tagged mesh whose caps have moved out along their normals by `radii[e]` times the radius of
/// ends[e] (0: stays), with a straight wall behind them; `ends` get their new centres and `extension`. The mesh must
/// have no removed elements. Throws InputError if an extension meets another part of the surface.
Mesh extended(const Mesh& mesh, std::vector<End>& ends, const std::vector<double>& radii);

} // namespace anatomy
