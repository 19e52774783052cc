// Reads labelled masks (NIfTI, NRRD, MetaImage), and makes the surface of a label with sub-voxel accuracy.
#pragma once
#include "core/types.hpp"
#include <optional>
#include <vector>
#include <vtkImageData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

namespace anatomy {

/// Integer labels on a grid of unit spacing with its origin at 0. `to_file` maps a voxel index to the file's own frame
/// and unit. In NIfTI x points right, y to the front and z up; in NRRD and MetaImage the header gives the directions.
struct Mask {
  vtkSmartPointer<vtkImageData> labels;
  Eigen::Matrix4d to_file = Eigen::Matrix4d::Identity();
};

/// Whether the suffix is one of a mask: .nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd.
bool is_mask_file(const std::string& path);

/// Reads a mask. Throws InputError if it is unreadable or not three-dimensional, or if the affine gives the voxels no
/// volume. It also throws for voxels with several components or with values that are not whole numbers.
Mask read_mask(const std::string& path);

/// The surface of one label, or of several taken together, in the file's unit. The image that is 1 in the label and 0
/// elsewhere is smoothed by 2 G(s) - G(2 s), where G is a Gaussian and s = 0.85 voxels. The surface is the level 0.5.
/// At a wall of radius R the value of G(s) is lower than 0.5 by s / (2 R sqrt(2 pi)). So G(s) alone would move the wall
/// inward by s^2 / 2 R. This deficit is in proportion to s, so it cancels in 2 G(s) - G(2 s): to first order in s / R a
/// curved wall does not move. keep_one_island() chooses the piece of the label that is kept. A label that reaches the
/// image's border is reported.
/// @param wanted labels that are taken together; empty for the only label in the mask
/// @param inlet a point in the piece to keep, in the file's unit; without it the largest piece is kept
/// Throws InputError if the label is absent or ambiguous, if the lumen is too thin for the voxels, or if a narrowing is
/// lost between the voxels.
vtkSmartPointer<vtkPolyData> surface_of_label(const Mask& mask, const std::vector<int>& wanted, const std::string& path,
                                              const std::optional<Vec3>& inlet, std::vector<Repair>& repairs);

/// Field data of the surface: the longest edge of a voxel as segmented, in the file's unit.
constexpr const char* voxel_edge_array = "voxel_edge";

} // namespace anatomy
