// The pieces of a label in a mask: which one is the lumen, and what the others are.
#pragma once
#include "mask/mask_file.hpp"
#include <optional>

namespace anatomy {

/// Keeps one connected piece of the label in `indicator` (1 in the label, 0 elsewhere) and sets the others to 0. Pieces
/// that touch at corners or edges of their voxels are joined first. The largest piece is kept, or the one nearest to
/// `inlet` (in the file's unit) among the largest and those as long as a vessel, 8 longest voxel edges. `repairs` takes
/// a note of the changes, and a warning with the place of each dropped piece that is as long as a vessel.
/// Throws InputError if one to three slices without the label separate the kept piece from the vessel behind them.
void keep_one_island(vtkImageData* indicator, const Mask& mask, const std::optional<Vec3>& inlet,
                     std::vector<Repair>& repairs);

/// Fills the cavities of the kept piece: sets the voxels that it encloses to 1. `repairs` takes a note, which is a
/// warning from 9 voxels on: they may be calcium or a thrombus that was cut out of the label.
void fill_cavities(vtkImageData* indicator, const Mask& mask, std::vector<Repair>& repairs);

/// Text for a message: the place of a voxel in the file's coordinates and unit.
/// @param voxel index (i, j, k, 1)
std::string place_in_file(const Mask& mask, const Eigen::Vector4d& voxel);

/// Length of a voxel's longest edge, in the file's unit.
double longest_edge(const Mask& mask);

} // namespace anatomy
