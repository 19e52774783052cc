// The scatter of a section's outline about a smooth closed outline.
#pragma once
#include "core/slices.hpp"

namespace anatomy {

/// Standard deviation (mm) that the roughness of one closed outline gives to its mean radius; negative if the outline
/// is too coarse to tell. The distance of the outline from a smooth closed one is split into waves round it. The wall's
/// noise is equally strong in waves of every length, and the mean radius is the longest of them. The lumen's own shape
/// is in the long waves only. So the noise is read from waves of 0.6 to 1.2 mm, or of 3 to 6 edges if edges are longer
/// than 0.2 mm.
/// @param edge mm between the measured points of the wall, which is straight between them
double mean_radius_scatter(const std::vector<Vec2>& outline, double edge);

/// Mean edge (mm) of the triangles that were cut, by the number of edges that a length of the outline crosses.
double edge_by_crossings(const std::vector<Vec2>& outline);

} // namespace anatomy
