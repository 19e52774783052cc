// Finds the label of the lumen in a mask.
#pragma once
#include <string>
#include <vector>
#include <vtkImageData.h>
#include <vtkIntArray.h>

namespace anatomy {

/// Throws InputError if an image is not three-dimensional, or if its voxels have several components or values that are
/// not whole numbers.
void check_labels(vtkImageData* image, const std::string& path);

/// The lumen's label. If each branch has its own label and several are wanted, all their voxels get the smallest one.
/// @param wanted the user's labels; empty for the only label in the mask
/// @param path path of the mask, for messages
/// Throws InputError if a label is absent or ambiguous, or fills the image.
int join_labels(vtkIntArray* labels, const std::vector<int>& wanted, const std::string& path);

} // namespace anatomy
