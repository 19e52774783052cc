// Where a mask's voxels are too large for the lumen they show.
#pragma once
#include "measure/lesions.hpp"

namespace anatomy {

/// The voxels that a lumen was segmented on.
struct Voxels {
  double edge = 0;      ///< mm, a voxel's longest edge; 0: not known
  bool of_mask = false; ///< whether a mask file gives it; else it was inferred from the vertices of a surface
};

/// Appends a note if sections have a radius below fewest_voxels voxel edges, with the place and radius of the
/// narrowest. Such a section is often the lesion itself, so it is measured, not refused. The note is a warning if the
/// result may change: at a lesion's smallest area (after set_area_errors), or in half the lumen.
void note_few_voxels(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                     const std::vector<Lesion>& lesions, const Voxels& voxels, std::vector<Repair>& notes);

/// The error of areas that these voxels cause in thin lumens, as a line of text; empty if no voxels are known.
std::string line_of(const Voxels& voxels);

/// Sets each lesion's mla_error, the possible error of its smallest area by the voxels.
void set_area_errors(std::vector<Lesion>& lesions, const Voxels& voxels);

constexpr double fewest_voxels = 2;

} // namespace anatomy
