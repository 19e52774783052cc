// Closes the openings of a surface: ends of the vessel by flat caps, and tears in the wall by filling. Boolean unions
// leave such tears at the seams of vessels.
#pragma once
#include "ends/open_end.hpp"
#include "repair/repair.hpp"

namespace anatomy {

/// Returns a test that tells whether one of the points (mm) names a loop as an end. The point must be within three
/// radii of the loop's centre. The loop must be at least as wide as the fraction `least_width` (evidence.hpp) of the
/// vessel behind it. So the mouth of a funnel is an end, although its lip lies in the plane of the rim. A hole in a
/// closed end is no end.
IsGivenEnd ends_at_points(std::vector<Vec3> points);

/// Fills every opening that is narrower than the fraction `least_width` (evidence.hpp) of the vessel behind it. Each
/// gives a warning in `repairs`. The same fraction tells a flat end of a closed surface from its wall. An opening
/// within three radii of one of the points `named` (mm) stays open. Throws InputError if a hole cannot be filled.
void fill_tears(Mesh& mesh, const std::vector<Vec3>& named, std::vector<Repair>& repairs);

/// Closes every opening with a flat cap, after moving the rim onto its plane (`Loop::normal`). Each cap gets its own
/// tag, counted on from the largest tag in use. Where moving the rim would crumple the wall, the end is closed as it
/// is, without a tag. Returns the ends for cut_ragged. Throws InputError if a rim is too ragged to be cut, or if an end
/// cannot be closed.
std::vector<OpenEnd> cap_open_ends(Mesh& mesh, std::vector<Repair>& repairs);

} // namespace anatomy
