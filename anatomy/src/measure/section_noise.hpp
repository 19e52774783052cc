// The noise of section areas by a rough wall, and areas smoothed against it.
#pragma once
#include "measure/sections.hpp"

namespace anatomy {

/// Relative standard deviation of the areas by noise, at a section of radius 1.5 mm; it grows as R^-1.5 towards thin
/// branches. It is the median over the sections' outlines, each by its own roughness (`Section::scatter`). Changes from
/// one section to the next do not count, since they may be the lumen's. 0 if there are too few sections to tell.
double area_noise(const std::vector<Section>& sections);

/// If area_noise is above least_area_noise, replaces the areas of the sections flagged ok by a smooth profile of the
/// radius along each branch. The profile is a straight line, or a discrete spline with third differences as its
/// penalty; Mallows' C_p for that noise chooses. Smallest and largest diameter keep their ratio to the equivalent
/// diameter. A surface without noise keeps the areas as cut. Appends a note of the smoothing to `notes`.
void smooth_noisy_areas(const std::vector<Branch>& branches, std::vector<Section>& sections,
                        std::vector<Repair>& notes);

constexpr double least_area_noise = 0.005; ///< computed, deformed and intravascular surfaces have up to 0.002

} // namespace anatomy
