// Rounded and ragged ends of a closed surface cut flat, and vessels cut across where the user asks.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// Cuts off the tips of vessels that end in no cap of `ends`, by a plane across the vessel's axis: half a radius inside
/// the last inscribed ball, or further in where the radius still grows. All such tips are cut where fewer than two ends
/// are known; else only those within three radii of one of `wanted` (mm), and the others are noted in `repairs` as left
/// closed. The openings are left for cap_open_ends. Returns whether it cut. Throws InputError where a plane does not
/// separate a tip.
bool cut_tips(Mesh& mesh, const std::vector<End>& ends, const std::vector<Vec3>& wanted, std::vector<Repair>& repairs);

/// Cuts the vessel across its axis at the point of the axis nearest to each of `points` (mm) and drops the smaller
/// side. Throws InputError if a point is farther from the axis than three radii, or the plane does not separate the
/// vessel.
void cut_across(Mesh& mesh, const std::vector<End>& ends, const std::vector<Vec3>& points,
                std::vector<Repair>& repairs);

} // namespace anatomy
