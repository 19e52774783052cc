// Finds the label of the lumen in a mask.
#pragma once
#include <string>
#include <vtkImageData.h>
#include <vtkIntArray.h>

namespace anatomy {

/// Throws InputError if an image is not three-dimensional, or has several components a voxel or values that are not
/// whole numbers.
void check_labels(vtkImageData* image, const std::string& path);

/// The lumen's label: the requested one, or for any_label the only one in the mask. Throws InputError if it is absent
/// or ambiguous, or fills the image.
int chosen_label(vtkIntArray* labels, int label, const std::string& path);

constexpr int any_label = 0;

} // namespace anatomy
