// How far a section's outline scatters about a smooth closed outline.
#pragma once
#include "core/slices.hpp"

namespace anatomy {

/// Standard deviation (mm) that the roughness of one closed outline gives to its mean radius; negative where the
/// outline is too coarse to tell. The part of the outline across a smooth closed one is taken apart into waves round
/// it. Noise of the wall is in all of them alike, the mean radius being the longest, whereas the lumen's own shape is
/// in the long ones only: those of 0.6 to 1.2 mm tell (where the edges are longer than 0.2 mm, of 3 to 6 edges).
/// `edge`: mm, between the measured points of the wall, between which it is drawn straight.
double mean_radius_scatter(const std::vector<Vec2>& outline, double edge);

/// Mean edge (mm) of the triangles that were cut, by how many edges a length of the outline crosses.
double edge_by_crossings(const std::vector<Vec2>& outline);

} // namespace anatomy
