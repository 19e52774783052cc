// Flat caps for the openings of a surface; tears in the wall, as boolean unions leave them at seams, are filled.
#pragma once
#include "ends/open_end.hpp"

namespace anatomy {

/// Fills every opening that is narrower than the vessel behind it (`least_width` of evidence.hpp), as a flat part of a
/// closed surface would be wall there. An opening near one of the points (mm) is the user's to name, and stays.
void fill_tears(Mesh& mesh, const std::vector<Vec3>& named, std::vector<Repair>& repairs);

/// Closes every open end with a flat cap (its rim is moved onto its least-squares plane first) and tags the cap's faces
/// 1, 2, ... after the regions in use. Rims that this would crumple are closed as they are, without a tag. Returns what
/// cut_ragged needs. Throws InputError if a rim is too ragged for that, or cannot be closed.
std::vector<OpenEnd> cap_open_ends(Mesh& mesh, std::vector<Repair>& repairs);

} // namespace anatomy
