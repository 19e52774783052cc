// The scatter of a section's outline about a smooth closed outline.
#pragma once
#include "core/slices.hpp"

namespace anatomy {

/// Standard deviation (mm) that the wall's noise gives to a section's mean radius; negative if the outline is too
/// coarse to tell. The outline's distance from a smooth closed outline is split into waves round it. The noise is taken
/// to be white, that is equally strong at every wavelength. The part that is constant round the outline is the error of
/// the mean radius. It cannot be measured itself, since the long waves also hold the lumen's own shape. So the noise is
/// measured from waves of 0.6 to 1.2 mm, or of 3 to 6 edges if edges are longer than 0.2 mm.
/// @param outline corners of the section (mm), in its plane
/// @param edge distance (mm) between neighbouring measured points of the wall, which is straight between them
double mean_radius_scatter(const std::vector<Vec2>& outline, double edge);

/// Mean edge (mm) of the triangles that the section cuts, from the outline's length and the number of edges it crosses.
double edge_by_crossings(const std::vector<Vec2>& outline);

} // namespace anatomy
