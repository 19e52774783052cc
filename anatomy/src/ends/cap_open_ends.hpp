// Flat caps for the openings of a surface.
#pragma once
#include "ends/open_end.hpp"

namespace anatomy {

/// Closes every open end with a flat cap (its rim is moved onto its least-squares plane first) and tags the cap's faces
/// 1, 2, ... after the regions in use. Rims that this would crumple are closed as they are, without a tag. Returns what
/// cut_ragged needs. Throws InputError if a rim is too ragged for that, or cannot be closed.
std::vector<OpenEnd> cap_open_ends(Mesh& mesh, std::vector<Repair>& repairs);

} // namespace anatomy
