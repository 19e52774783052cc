// Flat caps for the openings of a surface; tears in the wall, as boolean unions leave them at seams, are filled.
#pragma once
#include "ends/open_end.hpp"
#include "repair/repair.hpp"

namespace anatomy {

/// Whether one of the points (mm) is near the loop, which is as wide as the vessel behind it. So the mouth of a funnel,
/// whose lip lies in the plane of its rim, is an end, and a hole in a closed end is none.
IsGivenEnd named_by(std::vector<Vec3> points);

/// Fills every opening that is narrower than the vessel behind it, by `least_width` of evidence.hpp. By the same rule a
/// flat part of a closed surface is wall. An opening near one of the points `named` (mm) stays open. Throws InputError
/// if a hole cannot be filled.
void fill_tears(Mesh& mesh, const std::vector<Vec3>& named, std::vector<Repair>& repairs);

/// Closes every open end with a flat cap (its rim is moved onto its least-squares plane first) and tags the cap's faces
/// 1, 2, ... after the regions in use. Where this would crumple the wall, the rim is closed as it is, without a tag.
/// Returns the ends for cut_ragged. Throws InputError if a rim is too ragged to be cut, or cannot be closed.
std::vector<OpenEnd> cap_open_ends(Mesh& mesh, std::vector<Repair>& repairs);

} // namespace anatomy
