// Labelled masks as segmentation programs write them: NIfTI, NRRD, MetaImage; and the sub-voxel surface of a label.
#pragma once
#include "core/types.hpp"
#include <optional>
#include <vector>
#include <vtkImageData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

namespace anatomy {

/// Integer labels on a grid of unit spacing from the origin; to_file is voxel index to the file's own frame and unit
/// (NIfTI: x right, y front, z up; NRRD and MetaImage: as their headers say).
struct Mask {
  vtkSmartPointer<vtkImageData> labels;
  Eigen::Matrix4d to_file = Eigen::Matrix4d::Identity();
};

/// Whether the suffix is a mask's: .nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd.
bool is_mask_file(const std::string& path);

/// Throws InputError: unreadable or not three-dimensional, several components a voxel, values that are not whole
/// numbers, or an affine that is singular.
Mask read_mask(const std::string& path);

/// The surface of one label, or several taken together, in the file's unit. The label's indicator function is smoothed
/// by 2 G(s) - G(2 s), where G is a Gaussian and s = 0.85 voxels; the surface is its level 0.5. One Gaussian would move
/// a wall of radius R inward by s^2 / 2 R. The one-sided moments of the two cancel, so that to first order a curved
/// wall does not move. One piece of the label is kept, by keep_one_island. A label that reaches the image's border is
/// reported.
/// @param wanted labels that are taken together; empty for the only label in the mask
/// @param inlet in the file's unit, in the piece that is kept; none for the largest piece
/// Throws InputError if the label is absent or ambiguous, if the lumen is too thin for its voxels, or if a narrowing is
/// lost between them.
vtkSmartPointer<vtkPolyData> surface_of_label(const Mask& mask, const std::vector<int>& wanted, const std::string& path,
                                              const std::optional<Vec3>& inlet, std::vector<Repair>& repairs);

constexpr const char* voxel_edge_array =
    "voxel_edge"; ///< of the surface's field data: a voxel's longest edge, as it was segmented

} // namespace anatomy
