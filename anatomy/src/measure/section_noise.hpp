// The scatter that a rough wall gives to the areas of its sections, and the areas without it.
#pragma once
#include "measure/sections.hpp"

namespace anatomy {

/// Relative standard deviation of the areas that is noise, at a section of radius 1.5 mm. It is the median of what each
/// outline's own roughness does to its mean radius (`Section::scatter`), and grows as R^-1.5 towards thin branches.
/// Changes from one section to the next do not count, since they may be the lumen's. 0 where there are too few sections
/// to tell.
double area_noise(const std::vector<Section>& sections);

/// Where area_noise is above least_area_noise, replaces the areas of the sections flagged ok by those of a smooth
/// profile of the radius along each branch. The profile is a straight line, or a discrete spline with third differences
/// as its penalty; Mallows' C_p chooses for that noise. The diameters keep their ratio to the equivalent one. A surface
/// without noise keeps the areas as cut. Appends what was done to `notes`.
void smooth_noisy_areas(const std::vector<Branch>& branches, std::vector<Section>& sections,
                        std::vector<Repair>& notes);

constexpr double least_area_noise = 0.005; ///< computed, deformed and intravascular ones have up to 0.002

} // namespace anatomy
