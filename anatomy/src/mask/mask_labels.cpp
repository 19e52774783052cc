#include "mask/mask_labels.hpp"
#include "common/error.hpp"
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vtkDataArrayRange.h>
#include <vtkPointData.h>

namespace anatomy {
namespace {

using common::InputError;

constexpr std::size_t most_named = 10; // largest number of labels that a message lists
constexpr double largest_label = 2e9;  // largest absolute value of a label, since labels are stored as int
constexpr double fullest_image = 0.9;  // largest share of the image in a label; a tube fills pi / 4 of its bounding box

std::string known_labels(const std::map<int, vtkIdType>& counts) {
  std::string known;
  std::size_t named = 0;
  for (const auto& [value, count] : counts) {
    if (named++ == most_named)
      return known + " and " + std::to_string(counts.size() - most_named) + " more";
    known += (known.empty() ? "" : ", ") + std::to_string(value) + " (" + std::to_string(count) + " voxels)";
  }
  return known;
}

void check_not_the_background(vtkIdType voxels, vtkIdType all, const std::string& path) {
  if (voxels > fullest_image * static_cast<double>(all))
    throw InputError("the label fills the image, as no vessel does", path,
                     std::to_string(voxels) + " of " + std::to_string(all) + " voxels",
                     "name the lumen's label (--label, label in a case file), with 0 outside it");
}

} // namespace

void check_labels(vtkImageData* image, const std::string& path) {
  const int* size = image->GetDimensions();
  if (image->GetNumberOfScalarComponents() != 1 || std::min({size[0], size[1], size[2]}) < 2)
    throw InputError("not a three-dimensional mask", path,
                     std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " + std::to_string(size[2]) +
                         " voxels of " + std::to_string(image->GetNumberOfScalarComponents()) + " components",
                     "give one scalar label for each voxel of a volume");
  vtkIdType n = 0;
  for (const double value : vtk::DataArrayValueRange<1>(image->GetPointData()->GetScalars())) {
    if (value != std::round(value) || std::abs(value) > largest_label)
      throw InputError("the image is not a labelled mask", path,
                       "value " + std::to_string(value) + " at voxel " + std::to_string(n % size[0]) + ", " +
                           std::to_string(n / size[0] % size[1]) + ", " + std::to_string(n / size[0] / size[1]) +
                           " (the first is 0, 0, 0)",
                       "save the segmentation as a labelmap: whole numbers, 0 outside the lumen");
    ++n;
  }
}

int join_labels(vtkIntArray* labels, const std::vector<int>& wanted, const std::string& path) {
  std::map<int, vtkIdType> counts;
  for (const int value : vtk::DataArrayValueRange<1>(labels))
    if (value != 0)
      ++counts[value];
  if (counts.empty())
    throw InputError("the mask is empty", path, "no voxel other than 0",
                     "save the segmentation with the lumen's voxels other than 0");
  std::set<int> chosen(wanted.begin(), wanted.end());
  if (wanted.empty() && counts.size() == 1)
    chosen.insert(counts.begin()->first);
  const auto absent = [&](int label) { return !counts.contains(label); };
  if (chosen.empty() || std::any_of(chosen.begin(), chosen.end(), absent))
    throw InputError(chosen.empty() ? "the mask has several labels" : "no such label in the mask", path,
                     known_labels(counts),
                     "name the lumen's, or those of all its branches (--label 1 or 1,2; label in a case file); an "
                     "image of the CT itself goes in as lumen: {ct: ...}");
  vtkIdType voxels = 0;
  for (const int label : chosen)
    voxels += counts.at(label);
  check_not_the_background(voxels, labels->GetNumberOfValues(), path);
  for (int& value : vtk::DataArrayValueRange<1>(labels))
    if (chosen.contains(value))
      value = *chosen.begin();
  return *chosen.begin();
}

} // namespace anatomy
