// The noise of section areas that a rough wall causes, and its removal by smoothing along the axis.
#pragma once
#include "measure/sections.hpp"

namespace anatomy {

/// Relative standard deviation that noise gives to the area of a section of radius 1.5 mm. For other radii R it varies
/// as R^-1.5. It is the median over all sections, each judged by its own outline's roughness (`Section::scatter`).
/// Differences between neighbouring sections do not count, since they may be real. 0 if there are too few sections to
/// tell.
double area_noise(const std::vector<Section>& sections);

/// If area_noise is above least_area_noise, replaces the areas of the sections flagged ok by a smooth profile of the
/// radius along each branch. The profile is a straight line, or a discrete spline whose third differences are
/// penalised. Mallows' C_p for that noise chooses between them. Smallest and largest diameter keep their ratio to the
/// equivalent diameter. A surface without noise keeps the areas as cut. Appends a note of the smoothing to `notes`.
void smooth_noisy_areas(const std::vector<Branch>& branches, std::vector<Section>& sections,
                        std::vector<Repair>& notes);

/// Areas with less noise stay as cut. Computed, deformed and intravascular surfaces have up to 0.002.
constexpr double least_area_noise = 0.005;

} // namespace anatomy
