// Finds lumens that are too thin for the voxels in which they were segmented.
#pragma once
#include "measure/lesions.hpp"

namespace anatomy {

/// The size and the source of the voxels in which a lumen was segmented.
struct Voxels {
  double edge = 0;        ///< longest edge (mm) of a voxel; 0 if not known
  bool from_mask = false; ///< whether a mask file gives the edge; else it is inferred from the vertices of a surface
};

/// Appends a note if sections have a radius below fewest_voxels voxel edges, with the place and radius of the
/// narrowest. Such a section is often the lesion itself, so it is measured, not refused. The note is a warning if a
/// lesion's smallest area is affected, or more than half of the sections. Call set_area_errors() first.
void note_few_voxels(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                     const std::vector<Lesion>& lesions, const Voxels& voxels, std::vector<Repair>& notes);

/// A line of text that states the error of thin lumens' areas by these voxels; empty if no voxels are known.
std::string area_error_line(const Voxels& voxels);

/// Sets each lesion's mla_error: the possible error (per cent) of its smallest area by the voxels.
void set_area_errors(std::vector<Lesion>& lesions, const Voxels& voxels);

constexpr double fewest_voxels = 2; ///< the area of a lumen with a smaller radius (in voxel edges) may be wrong

} // namespace anatomy
