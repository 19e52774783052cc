// Where a mask's voxels are too large for the lumen they show.
#pragma once
#include "measure/sections.hpp"

namespace anatomy {

/// Appends a warning where sections have a radius below fewest_voxels edges of a voxel (mm; 0: no mask), with the place
/// and the radius of the narrowest. A narrowing below that is often the lesion itself, so it is measured, not refused.
void warn_of_few_voxels(const std::vector<Branch>& branches, const std::vector<Section>& sections, double voxel,
                        std::vector<Repair>& notes);

constexpr double fewest_voxels = 2;

} // namespace anatomy
