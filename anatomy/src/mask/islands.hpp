// The pieces of a label in a mask: which one is the lumen, and what the others are.
#pragma once
#include "mask/mask_file.hpp"
#include <optional>

namespace anatomy {

/// Sets all pieces of the indicator (1 in the label, 0 elsewhere) to 0 but one: the largest, or the one nearest to
/// `inlet` (in the file's unit) among those as long as a vessel. Pieces that touch by corners or edges of their voxels
/// are joined first. `repairs` takes a warning of each piece that is as long as a vessel, with its place.
/// Throws InputError if up to three slices without the label divide the kept piece from the vessel behind them.
void keep_one_island(vtkImageData* indicator, const Mask& mask, const std::optional<Vec3>& inlet,
                     std::vector<Repair>& repairs);

/// Sets the voxels that the piece encloses to 1. `repairs` takes a note, and a warning from 9 voxels on: they may be
/// calcium or a thrombus that was cut out of the label.
void fill_cavities(vtkImageData* indicator, const Mask& mask, std::vector<Repair>& repairs);

/// A place in the file's coordinates, in the file's own unit, for a message.
std::string place_in_file(const Mask& mask, const Eigen::Vector4d& voxel);

/// The longest edge of a voxel, in the file's unit.
double longest_edge(const Mask& mask);

} // namespace anatomy
