// Finds the label of the lumen in a mask.
#pragma once
#include <string>
#include <vector>
#include <vtkImageData.h>
#include <vtkIntArray.h>

namespace anatomy {

/// Throws InputError if an image is not three-dimensional, or has several components a voxel or values that are not
/// whole numbers.
void check_labels(vtkImageData* image, const std::string& path);

/// The lumen's label. Of several wanted labels, as of branches that have one each, the voxels of all get the first.
/// @param wanted empty for the only label in the mask
/// Throws InputError if a label is absent or ambiguous, or fills the image.
int join_labels(vtkIntArray* labels, const std::vector<int>& wanted, const std::string& path);

} // namespace anatomy
