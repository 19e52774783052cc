#include "surface_file.hpp"
#include "common/error.hpp"
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <openssl/evp.h>
#include <sstream>
#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkOBJReader.h>
#include <vtkPLYReader.h>
#include <vtkSTLReader.h>
#include <vtkTriangleFilter.h>
#include <vtkXMLPolyDataReader.h>

namespace anatomy {
namespace {

using common::InputError;

template <class Reader> vtkSmartPointer<vtkPolyData> read_with(const std::string& path) {
  auto reader = vtkSmartPointer<Reader>::New();
  reader->SetFileName(path.c_str());
  reader->Update();
  return reader->GetOutput();
}

vtkSmartPointer<vtkPolyData> read_by_suffix(const std::string& path) {
  std::string suffix = std::filesystem::path(path).extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(), [](unsigned char c) { return std::tolower(c); });
  if (suffix == ".stl")
    return read_with<vtkSTLReader>(path);
  if (suffix == ".vtp")
    return read_with<vtkXMLPolyDataReader>(path);
  if (suffix == ".ply")
    return read_with<vtkPLYReader>(path);
  if (suffix == ".obj")
    return read_with<vtkOBJReader>(path);
  throw InputError("unknown surface format", path, suffix.empty() ? "no suffix" : suffix,
                   "give a .stl, .vtp, .ply or .obj file");
}

std::string figure(double value) {
  std::ostringstream text;
  text.precision(4);
  text << value;
  return text.str();
}

// A unit in which `size` (mm under the declared unit) lies between lowest and highest, or "" if none does.
std::string likely_unit(double size, const std::string& units, double lowest, double highest) {
  for (const std::string candidate : {"mm", "cm", "m"}) {
    const double scaled = size / millimetres_per(units) * millimetres_per(candidate);
    if (scaled >= lowest && scaled <= highest)
      return candidate;
  }
  return "";
}

void check_range(double size, double lowest, double highest, const std::string& what, const std::string& units,
                 const std::string& path) {
  if (size >= lowest && size <= highest)
    return;
  const std::string likely = likely_unit(size, units, lowest, highest);
  throw InputError("implausible scale for a coronary lumen", path,
                   what + " " + figure(size) + " mm with units " + units + ", expected " + figure(lowest) + " to " +
                       figure(highest) + " mm",
                   likely.empty() ? "check that the file is a coronary lumen surface"
                                  : "the file is likely in " + likely + ": declare units " + likely);
}

} // namespace

double millimetres_per(const std::string& units) {
  if (units == "mm")
    return 1;
  if (units == "cm")
    return 10;
  if (units == "m")
    return 1000;
  throw InputError("unknown length unit", "units", units, "declare mm, cm or m");
}

void check_diagonal(double diagonal_mm, const std::string& units, const std::string& path) {
  check_range(diagonal_mm, 4, 500, "bounding diagonal", units, path);
}

void check_mean_radius(double radius_mm, const std::string& units, const std::string& path) {
  check_range(radius_mm, 0.2, 8, "mean radius", units, path);
}

vtkSmartPointer<vtkPolyData> read_surface(const std::string& path, const std::string& units) {
  const double scale = millimetres_per(units);
  if (!std::filesystem::is_regular_file(path))
    throw InputError("no such surface file", path, "missing", "check the path");
  auto triangulate = vtkSmartPointer<vtkTriangleFilter>::New();
  triangulate->SetInputData(read_by_suffix(path));
  triangulate->PassVertsOff();
  triangulate->PassLinesOff();
  triangulate->Update();
  vtkSmartPointer<vtkPolyData> data = triangulate->GetOutput();
  if (data->GetNumberOfCells() < 4)
    throw InputError("no surface in the file", path, std::to_string(data->GetNumberOfCells()) + " triangles",
                     "check that the file is complete and holds a triangulated surface");
  auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(data->GetNumberOfPoints());
  for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i) {
    double x[3];
    data->GetPoint(i, x);
    if (!std::isfinite(x[0]) || !std::isfinite(x[1]) || !std::isfinite(x[2]))
      throw InputError("a coordinate is not a finite number", path, "point " + std::to_string(i),
                       "export the surface again");
    points->SetPoint(i, x[0] * scale, x[1] * scale, x[2] * scale);
  }
  data->SetPoints(points);
  check_diagonal(data->GetLength(), units, path);
  return data;
}

Soup soup_of(vtkPolyData* data) {
  Soup soup;
  for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i) {
    const double* x = data->GetPoint(i);
    soup.points.emplace_back(x[0], x[1], x[2]);
  }
  vtkIdType n = 0;
  const vtkIdType* ids = nullptr;
  auto cells = vtk::TakeSmartPointer(data->GetPolys()->NewIterator());
  for (cells->GoToFirstCell(); !cells->IsDoneWithTraversal(); cells->GoToNextCell()) {
    cells->GetCurrentCell(n, ids);
    soup.triangles.push_back(
        {static_cast<std::size_t>(ids[0]), static_cast<std::size_t>(ids[1]), static_cast<std::size_t>(ids[2])});
  }
  if (vtkDataArray* region = data->GetCellData()->GetArray("region_id"))
    for (vtkIdType i = 0; i < region->GetNumberOfTuples(); ++i)
      soup.region.push_back(static_cast<int>(region->GetTuple1(i)));
  return soup;
}

std::string sha256_of_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> digest(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  bool ok = file && digest && EVP_DigestInit_ex(digest.get(), EVP_sha256(), nullptr);
  std::array<char, 1 << 16> block;
  while (ok && (file.read(block.data(), block.size()) || file.gcount() > 0))
    ok = EVP_DigestUpdate(digest.get(), block.data(), static_cast<std::size_t>(file.gcount()));
  std::array<unsigned char, EVP_MAX_MD_SIZE> bytes;
  unsigned int length = 0;
  if (!ok || !EVP_DigestFinal_ex(digest.get(), bytes.data(), &length))
    throw InputError("the file cannot be read", path, "", "check its permissions");
  std::string hex;
  for (unsigned int i = 0; i < length; ++i) {
    char text[3];
    std::snprintf(text, sizeof text, "%02x", bytes[i]);
    hex += text;
  }
  return hex;
}

} // namespace anatomy
