// Which voxels of a mask are the lumen's.
#pragma once
#include <string>
#include <vtkImageData.h>
#include <vtkIntArray.h>

namespace anatomy {

/// Throws InputError where an image is not three-dimensional, has several components a voxel, or values that are not
/// whole numbers.
void check_labels(vtkImageData* image, const std::string& path);

/// The label to take: the one asked for, or (any_label) the only one there is. Throws InputError where it is absent or
/// ambiguous, or fills the image.
int chosen_label(vtkIntArray* labels, int label, const std::string& path);

constexpr int any_label = 0;

} // namespace anatomy
