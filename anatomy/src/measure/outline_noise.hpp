// The scatter of a section's outline about a smooth closed outline.
#pragma once
#include "core/slices.hpp"

namespace anatomy {

/// Standard deviation (mm) that the wall's noise gives to a section's mean radius; negative if the outline is too
/// coarse to tell. The outline's distance from a smooth closed outline is split into waves round it. Noise is taken to
/// be equally strong at every wavelength. An error of the mean radius is the longest wave. The lumen's own shape is in
/// the long waves only. So the noise is measured from waves of 0.6 to 1.2 mm, or of 3 to 6 edges if edges are longer
/// than 0.2 mm.
/// @param outline corners of the section (mm), in its plane
/// @param edge distance (mm) between neighbouring measured points of the wall, which is straight between them
double mean_radius_scatter(const std::vector<Vec2>& outline, double edge);

/// Mean edge (mm) of the triangles that the section cuts, from the outline's length and the number of edges it crosses.
double edge_by_crossings(const std::vector<Vec2>& outline);

} // namespace anatomy
