#include "mask/mask_file.hpp"
#include "common/error.hpp"
#include "mask/islands.hpp"
#include "mask/mask_header.hpp"
#include "mask/mask_labels.hpp"
#include "mask/nifti_check.hpp"
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <vtkDataArrayRange.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageCast.h>
#include <vtkImageGaussianSmooth.h>
#include <vtkImageWeightedSum.h>
#include <vtkMatrix4x4.h>
#include <vtkMetaImageReader.h>
#include <vtkNIFTIImageReader.h>
#include <vtkNrrdReader.h>
#include <vtkPointData.h>
#include <vtkPolyDataConnectivityFilter.h>
#include <vtkStaticPointLocator.h>

namespace anatomy {
namespace {

using common::InputError;

constexpr double smoothing = 0.85; // standard deviation of the narrower Gaussian, in voxels
constexpr double kernel_reach = 4; // a Gaussian kernel is cut off at this many standard deviations
constexpr int padding = 8;         // voxels of margin round the label, as the wider kernel reaches 2 * 0.85 * 4 = 6.8
// A piece with a smaller share of the largest piece's triangles is a spur of a few voxels.
constexpr double spur_share = 0.01;
constexpr std::size_t fewest_contact_faces = 4; // fewer voxel faces shared with other labels give no warning
constexpr double wall_contact_share = 0.2; // labels that touch a larger share of the label's outer faces are its wall
// Least volume of a voxel over the product of its edges. Skewed voxels have far more.
constexpr double flattest_voxel = 1e-6;

enum class MaskFormat { nifti, nrrd, meta };

// The format by the file's suffix; nothing if the suffix is no mask's.
std::optional<MaskFormat> format_of(const std::string& path) {
  std::string lower = path;
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const auto& [suffix, format] : {std::pair{".nii", MaskFormat::nifti},
                                       {".nii.gz", MaskFormat::nifti},
                                       {".nrrd", MaskFormat::nrrd},
                                       {".nhdr", MaskFormat::nrrd},
                                       {".mha", MaskFormat::meta},
                                       {".mhd", MaskFormat::meta}})
    if (lower.ends_with(suffix))
      return format;
  return std::nullopt;
}

// Affine from voxel index to the frame of a NIfTI file: its sform, else its qform, else the voxel sizes. VTK's matrices
// map the index times the voxel size, so their columns are scaled here. VTK has adapted the matrices to its reader's
// order of slices.
Eigen::Matrix4d nifti_affine(vtkNIFTIImageReader& reader) {
  vtkMatrix4x4* matrix = reader.GetSFormMatrix() ? reader.GetSFormMatrix() : reader.GetQFormMatrix();
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  for (int i = 0; matrix && i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      m(i, j) = matrix->GetElement(i, j);
  for (int j = 0; j < 3; ++j)
    m.col(j) *= reader.GetOutput()->GetSpacing()[j];
  return m;
}

// An image that is 1 where the label is and 0 elsewhere, cut to a box about the label with a margin of zeros.
vtkSmartPointer<vtkImageData> indicator_of(vtkImageData* labels, int label) {
  const int* size = labels->GetDimensions();
  const auto* values = static_cast<const int*>(labels->GetScalarPointer());
  std::array<int, 3> low{size[0], size[1], size[2]}, high{-1, -1, -1};
  const auto visit = [&](const auto& action) {
    std::size_t n = 0;
    for (int k = 0; k < size[2]; ++k)
      for (int j = 0; j < size[1]; ++j)
        for (int i = 0; i < size[0]; ++i)
          if (values[n++] == label)
            action(i, j, k);
  };
  visit([&](int i, int j, int k) {
    low = {std::min(low[0], i), std::min(low[1], j), std::min(low[2], k)};
    high = {std::max(high[0], i), std::max(high[1], j), std::max(high[2], k)};
  });
  auto box = vtkSmartPointer<vtkImageData>::New();
  box->SetExtent(low[0] - padding, high[0] + padding, low[1] - padding, high[1] + padding, low[2] - padding,
                 high[2] + padding);
  box->AllocateScalars(VTK_FLOAT, 1);
  box->GetPointData()->GetScalars()->Fill(0);
  visit([&](int i, int j, int k) { *static_cast<float*>(box->GetScalarPointer(i, j, k)) = 1; });
  return box;
}

// Number of voxels along each axis into which every segmented voxel was divided afterwards; 1 if none was. In a divided
// mask the borders of the label along an axis are multiples of this number apart. The smallest of the three axes
// counts.
int voxel_division(vtkImageData* indicator) {
  const int* extent = indicator->GetExtent();
  std::array<int, 3> common{0, 0, 0}, first{-1, -1, -1};
  for (int k = extent[4] + 1; k <= extent[5]; ++k)
    for (int j = extent[2] + 1; j <= extent[3]; ++j)
      for (int i = extent[0] + 1; i <= extent[1]; ++i) {
        const auto* here = static_cast<const float*>(indicator->GetScalarPointer(i, j, k));
        const std::array<int, 3> at{i, j, k};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if (*here == *(here - indicator->GetIncrements()[axis]))
            continue;
          if (first[axis] < 0)
            first[axis] = at[axis];
          common[axis] = std::gcd(common[axis], at[axis] - first[axis]);
        }
      }
  return std::max(1, *std::min_element(common.begin(), common.end()));
}

vtkSmartPointer<vtkImageData> smoothed(vtkImageData* image, double deviation) {
  vtkNew<vtkImageGaussianSmooth> smooth;
  smooth->SetInputData(image);
  smooth->SetDimensionality(3);
  smooth->SetStandardDeviation(deviation);
  smooth->SetRadiusFactor(kernel_reach);
  smooth->SetNumberOfThreads(1);
  smooth->Update();
  return smooth->GetOutput();
}

vtkSmartPointer<vtkPolyData> level_surface(vtkImageData* indicator) {
  vtkNew<vtkImageWeightedSum> field;
  field->AddInputData(smoothed(indicator, smoothing));
  field->AddInputData(smoothed(indicator, 2 * smoothing));
  field->SetWeight(0, 2);
  field->SetWeight(1, -1);
  field->NormalizeByWeightOff();
  vtkNew<vtkFlyingEdges3D> contour;
  contour->SetInputConnection(field->GetOutputPort());
  contour->SetValue(0, 0.5);
  contour->ComputeNormalsOff();
  contour->ComputeScalarsOff();
  contour->Update();
  return contour->GetOutput();
}

// Warns if the label reaches the image's border. A border across a vessel makes an end of the vessel. A border along a
// vessel cuts off part of the lumen, so that its sections are too small.
void report_border(const Mask& mask, int label, std::vector<Repair>& repairs) {
  const int* size = mask.labels->GetDimensions();
  const auto* values = static_cast<const int*>(mask.labels->GetScalarPointer());
  std::size_t n = 0, touching = 0;
  Eigen::Vector4d first = Eigen::Vector4d::Zero();
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i) {
        const bool border = i == 0 || j == 0 || k == 0 || i == size[0] - 1 || j == size[1] - 1 || k == size[2] - 1;
        if (values[n++] == label && border && touching++ == 0)
          first = Eigen::Vector4d(i, j, k, 1);
      }
  if (touching > 0)
    repairs.push_back({"lumen cut by the image's border", touching,
                       std::to_string(touching) + " voxels, first at " + place_in_file(mask, first) +
                           ". An end there lies along the border; --cut across the vessel before it gives a better one",
                       true});
}

// The point of region `from` that is nearest to region `to`, in voxel indices.
Eigen::Vector3d nearest_between(vtkPolyData* regions, int from, int to) {
  const auto region = vtk::DataArrayValueRange<1>(regions->GetPointData()->GetScalars());
  vtkNew<vtkPoints> targets;
  for (vtkIdType i = 0; i < regions->GetNumberOfPoints(); ++i)
    if (region[i] == to)
      targets->InsertNextPoint(regions->GetPoint(i));
  vtkNew<vtkPolyData> data;
  data->SetPoints(targets);
  vtkNew<vtkStaticPointLocator> locator;
  locator->SetDataSet(data);
  locator->BuildLocator();
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double least = 1e300;
  for (vtkIdType i = 0; i < regions->GetNumberOfPoints(); ++i) {
    if (region[i] != from)
      continue;
    const Eigen::Vector3d p(regions->GetPoint(i));
    const Eigen::Vector3d q(targets->GetPoint(locator->FindClosestPoint(p.data())));
    if ((p - q).norm() < least) {
      least = (p - q).norm();
      best = p;
    }
  }
  return best;
}

void check_one_piece(vtkPolyData* surface, const Mask& mask, const std::string& path) {
  vtkNew<vtkPolyDataConnectivityFilter> pieces;
  pieces->SetInputData(surface);
  pieces->SetExtractionModeToAllRegions();
  pieces->ColorRegionsOn();
  pieces->Update();
  vtkIdTypeArray* sizes = pieces->GetRegionSizes();
  const auto count = [&](int r) { return static_cast<double>(sizes->GetValue(r)); };
  int largest = 0;
  for (int r = 1; r < pieces->GetNumberOfExtractedRegions(); ++r)
    largest = count(r) > count(largest) ? r : largest;
  for (int r = 0; r < pieces->GetNumberOfExtractedRegions(); ++r) {
    if (r == largest || count(r) < spur_share * count(largest))
      continue;
    const Eigen::Vector3d x = nearest_between(pieces->GetOutput(), r, largest);
    throw InputError(
        "a narrowing of the mask is lost between its voxels", path,
        "a piece of the lumen stands alone near " + place_in_file(mask, Eigen::Vector4d(x[0], x[1], x[2], 1)),
        "halve the voxels of the labels (nearest neighbour), segment on smaller voxels, or give a surface");
  }
}

// Warns if the lumen's label touches other labels, since each branch of the lumen may have its own label. There is no
// warning if the other labels touch more than a fifth of the lumen's outer voxel faces: they are then its wall.
void report_neighbours(vtkImageData* labels, int label, std::vector<Repair>& repairs) {
  const int* size = labels->GetDimensions();
  const auto* values = static_cast<const int*>(labels->GetScalarPointer());
  const auto row = static_cast<std::ptrdiff_t>(size[0]), slice = row * size[1];
  std::map<int, std::size_t> touching; // faces of voxels, by the label on their other side
  std::size_t all = 0;
  const auto visit = [&](int one, int other) {
    if (one == other || (one != label && other != label))
      return;
    ++all;
    if (one != 0 && other != 0)
      ++touching[one == label ? other : one];
  };
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i) {
        const int here = *values;
        if (i + 1 < size[0])
          visit(here, values[1]);
        if (j + 1 < size[1])
          visit(here, values[row]);
        if (k + 1 < size[2])
          visit(here, values[slice]);
        ++values;
      }
  std::string others;
  std::size_t faces = 0;
  for (const auto& [other, count] : touching) {
    others += (others.empty() ? "" : ", ") + std::to_string(other);
    faces += count;
  }
  if (faces < fewest_contact_faces || static_cast<double>(faces) > wall_contact_share * static_cast<double>(all))
    return;
  repairs.push_back({"the lumen's label touches others", touching.size(),
                     "label " + std::to_string(label) + " goes on into " + others +
                         "; if these are branches of the lumen, name them all, as in --label " + std::to_string(label) +
                         "," + std::to_string(touching.begin()->first),
                     true});
}

} // namespace

bool is_mask_file(const std::string& path) {
  return format_of(path).has_value();
}

Mask read_mask(const std::string& path) {
  Mask mask;
  vtkSmartPointer<vtkImageData> image;
  const std::optional<MaskFormat> format = format_of(path);
  const auto check_length = [&](vtkImageReader2& reader) {
    const int* extent = reader.GetDataExtent();
    std::uintmax_t bytes = static_cast<std::uintmax_t>(vtkDataArray::GetDataTypeSize(reader.GetDataScalarType()));
    for (int k = 0; k < 6; k += 2)
      bytes *= static_cast<std::uintmax_t>(std::max(0, extent[k + 1] - extent[k] + 1));
    if (format == MaskFormat::nrrd)
      check_nrrd_length(path, bytes);
    else if (format == MaskFormat::nifti)
      check_nifti_length(path, bytes);
    else
      check_meta_length(path, bytes);
  };
  const auto read = [&](vtkImageReader2& reader) {
    if (!reader.CanReadFile(path.c_str()))
      throw InputError("the mask cannot be read", path, "not a file of its format", "export the mask again");
    reader.SetFileName(path.c_str());
    reader.UpdateInformation();
    check_length(reader);
    reader.Update();
    image = reader.GetOutput();
    if (reader.GetErrorCode() != 0 || !image->GetPointData()->GetScalars())
      throw InputError("the mask cannot be read", path, "incomplete or of an unknown encoding",
                       "export the mask again");
  };
  if (format == MaskFormat::nifti) {
    check_nifti_header(path);
    vtkNew<vtkNIFTIImageReader> reader;
    read(*reader);
    mask.to_file = nifti_affine(*reader);
  } else if (format == MaskFormat::nrrd) {
    mask.to_file = nrrd_affine(path);
    vtkNew<vtkNrrdReader> reader;
    read(*reader);
  } else {
    mask.to_file = meta_affine(path);
    vtkNew<vtkMetaImageReader> reader;
    read(*reader);
  }
  const double box = mask.to_file.topLeftCorner<3, 3>().colwise().norm().prod();
  if (!(std::abs(mask.to_file.determinant()) > flattest_voxel * box))
    throw InputError("the mask's header gives its voxels no volume", path,
                     "voxels of " + std::to_string(mask.to_file.determinant()) + " in the cube of the file's unit",
                     "export the mask again, with its voxels' edges and directions");
  check_labels(image, path);
  vtkNew<vtkImageCast> cast;
  cast->SetInputData(image);
  cast->SetOutputScalarTypeToInt();
  cast->Update();
  mask.labels = cast->GetOutput();
  mask.labels->SetOrigin(0, 0, 0);
  mask.labels->SetSpacing(1, 1, 1);
  mask.labels->SetDirectionMatrix(1, 0, 0, 0, 1, 0, 0, 0, 1);
  return mask;
}

vtkSmartPointer<vtkPolyData> surface_of_label(const Mask& mask, const std::vector<int>& wanted, const std::string& path,
                                              const std::optional<Vec3>& inlet, std::vector<Repair>& repairs) {
  const int chosen = join_labels(vtkIntArray::SafeDownCast(mask.labels->GetPointData()->GetScalars()), wanted, path);
  const auto indicator = indicator_of(mask.labels, chosen);
  const int divided = voxel_division(indicator);
  if (divided > 1)
    repairs.push_back({"voxels of the mask are divided", static_cast<std::size_t>(divided),
                       "along each axis; errors are stated for the undivided ones"});
  keep_one_island(indicator, mask, inlet, repairs);
  fill_cavities(indicator, mask, repairs);
  report_border(mask, chosen, repairs);
  report_neighbours(mask.labels, chosen, repairs);
  vtkSmartPointer<vtkPolyData> surface = level_surface(indicator);
  if (surface->GetNumberOfPolys() == 0)
    throw InputError("the lumen is too thin for the mask's voxels", path,
                     "nowhere two voxels of " + std::to_string(longest_edge(mask)) + " wide, in the file's own unit",
                     "resample the image to smaller voxels before segmenting, or give a surface");
  check_one_piece(surface, mask, path);
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (vtkIdType i = 0; i < surface->GetNumberOfPoints(); ++i) {
    const double* x = surface->GetPoint(i);
    const Eigen::Vector4d p = mask.to_file * Eigen::Vector4d(x[0], x[1], x[2], 1);
    points->InsertNextPoint(p.x(), p.y(), p.z());
  }
  surface->SetPoints(points);
  vtkNew<vtkDoubleArray> edge;
  edge->SetName(voxel_edge_array);
  edge->InsertNextValue(divided * longest_edge(mask));
  surface->GetFieldData()->AddArray(edge);
  if (mask.to_file.determinant() < 0) // a left-handed frame turns the triangles' normals inward
    for (vtkIdType i = 0; i < surface->GetNumberOfCells(); ++i)
      surface->GetPolys()->ReverseCellAtId(i);
  return surface;
}

} // namespace anatomy
