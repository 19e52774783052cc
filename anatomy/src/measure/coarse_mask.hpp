// Where a mask's voxels are too large for the lumen they show.
#pragma once
#include "measure/lesions.hpp"

namespace anatomy {

/// The voxels that a lumen was segmented on.
struct Voxels {
  double edge = 0;      ///< mm, the longest of a voxel; 0: none are known of
  bool of_mask = false; ///< whether the file says so; else they were found by the vertices of a surface
};

/// Appends a note where sections have a radius below fewest_voxels edges of a voxel, with the place and the radius of
/// the narrowest. A narrowing below that is often the lesion itself, so it is measured, not refused. The note is a
/// warning where the result may change: at a lesion's smallest area (after set_area_errors), or in half the lumen.
void note_few_voxels(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                     const std::vector<Lesion>& lesions, const Voxels& voxels, std::vector<Repair>& notes);

/// What these voxels mean for thin lumens, as a line of text; empty where none are known of.
std::string line_of(const Voxels& voxels);

/// Sets how far each lesion's smallest area may be off by its voxels.
void set_area_errors(std::vector<Lesion>& lesions, const Voxels& voxels);

constexpr double fewest_voxels = 2;

} // namespace anatomy
