#include "files/surface_file.hpp"
#include "common/error.hpp"
#include "common/vtk/vtp_check.hpp"
#include "files/obj_check.hpp"
#include "files/ply_check.hpp"
#include "mask/mask_file.hpp"
#include "mask/mask_labels.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <new>
#include <openssl/evp.h>
#include <sstream>
#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkOBJReader.h>
#include <vtkPLYReader.h>
#include <vtkSTLReader.h>
#include <vtkTriangleFilter.h>
#include <vtkXMLPolyDataReader.h>
#include <vtksys/SystemTools.hxx>

namespace anatomy {
namespace {

using common::InputError;

template <class Reader> vtkSmartPointer<vtkPolyData> read_with(const std::string& path) {
  auto reader = vtkSmartPointer<Reader>::New();
  reader->SetFileName(path.c_str());
  reader->Update();
  if (reader->GetErrorCode() != 0)
    throw InputError("the surface cannot be read", path, "incomplete or not of its format",
                     "export the surface again, or as STL");
  return reader->GetOutput();
}

// Refuses a path that is no regular file. The message says what it is instead.
void check_there(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code ignored; // set by a link to itself, which counts as broken
  const fs::file_status found = fs::status(path, ignored);
  if (fs::is_regular_file(found))
    return;
  const bool broken = fs::is_symlink(fs::symlink_status(path, ignored)) && !fs::exists(found);
  const std::string there = fs::is_directory(found) ? "a folder"
                            : fs::exists(found)     ? "a pipe or a device"
                            : broken                ? "a link that leads nowhere"
                                                    : "missing";
  throw InputError("no such surface file", path, there,
                   "check the path; a case file's is relative to the repository, after data/ to VCI_DATA_DIR");
}

// Refuses content that is often saved by mistake instead of a surface. It is recognised by its first bytes.
void check_kind(const std::string& path) {
  struct Other {
    std::string begin, what, remedy;
  };
  static const std::array<Other, 5> others{{{"<!doctype html", "a web page", "download the file itself"},
                                            {"<html", "a web page", "download the file itself"},
                                            {"version https://git-lfs", "a pointer of Git LFS", "git lfs pull"},
                                            {"\x1f\x8b", "compressed by gzip", "unpack it with gunzip"},
                                            {"PK\x03\x04", "a zip archive", "unpack it with unzip"}}};
  std::string head(32, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  if (head[0] == '<')
    std::transform(head.begin(), head.end(), head.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const Other& other : others)
    if (head.starts_with(other.begin) && !(is_mask_file(path) && other.begin[0] == '\x1f'))
      throw InputError("another file in the place of a surface", path, other.what, other.remedy);
}

// Bytes of a binary STL file's header and of each of its triangles.
constexpr std::uintmax_t stl_head = 84, stl_triangle = 50;

// Refuses a text STL file without its last line, endsolid. Such a file was cut off, and VTK's reader would take the
// rest for the whole.
void check_stl_text(std::ifstream& file, std::uintmax_t size, const std::string& path) {
  const std::uintmax_t length = std::min<std::uintmax_t>(size, 1024);
  std::string tail(length, ' ');
  file.clear();
  file.seekg(static_cast<std::streamoff>(size - length));
  file.read(tail.data(), static_cast<std::streamsize>(length));
  std::transform(tail.begin(), tail.end(), tail.begin(), [](unsigned char c) { return std::tolower(c); });
  if (tail.find("endsolid") == std::string::npos)
    throw InputError("the surface is incomplete", path, std::to_string(size) + " bytes without a last line endsolid",
                     "export it again");
}

// Refuses a binary STL file whose length does not fit its number of triangles. VTK's reader allocates memory for the
// number that the file claims, and reads no more triangles. VTK takes a file for text if nearly all of its first bytes
// are printable; the same function of VTK decides here.
void check_stl_length(const std::string& path) {
  std::array<unsigned char, stl_head> head{};
  std::ifstream file(path, std::ios::binary);
  const std::uintmax_t size = std::filesystem::file_size(path);
  file.read(reinterpret_cast<char*>(head.data()), head.size());
  std::uintmax_t count = 0;
  for (std::size_t k = 4; k-- > 0;)
    count = 256 * count + head[80 + k];
  const std::uintmax_t expected = stl_head + stl_triangle * count;
  if (vtksys::SystemTools::DetectFileType(path.c_str()) == vtksys::SystemTools::FileTypeText)
    return check_stl_text(file, size, path);
  if (size < expected || size >= expected + stl_triangle)
    throw InputError("the file's size is not that of its triangles", path,
                     std::to_string(size) + " bytes; its header says " + std::to_string(count) + " triangles, " +
                         std::to_string(expected) + " bytes",
                     "export it again");
}

vtkSmartPointer<vtkPolyData> read_by_suffix(const std::string& path, const std::vector<int>& labels,
                                            const std::optional<Vec3>& inlet, std::vector<Repair>& repairs) {
  if (is_mask_file(path))
    return surface_of_label(read_mask(path), labels, path, inlet, repairs);
  if (!labels.empty())
    throw InputError("only masks have labels", "--label", std::to_string(labels.front()) + " for " + path,
                     "leave the label out (--label, label in a case file), or give a mask");
  std::string suffix = std::filesystem::path(path).extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(), [](unsigned char c) { return std::tolower(c); });
  if (suffix == ".stl") {
    check_stl_length(path);
    return read_with<vtkSTLReader>(path);
  }
  if (suffix == ".vtp") {
    common::check_vtp(path, "surface");
    return read_with<vtkXMLPolyDataReader>(path);
  }
  if (suffix == ".ply") {
    check_ply(path);
    return read_with<vtkPLYReader>(path);
  }
  if (suffix == ".obj") {
    check_obj(path);
    return read_with<vtkOBJReader>(path);
  }
  throw InputError(
      "unknown surface format", path, suffix.empty() ? "no suffix" : suffix,
      "give a surface (.stl, .vtp, .ply, .obj) or a labelled mask (.nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd)");
}

std::string figure(double value) {
  std::ostringstream text;
  text.precision(4);
  text << value;
  return text.str();
}

// A unit in which `size` lies between lowest and highest (mm), or nothing if it does in none. `size` is in mm under the
// declared unit.
std::optional<LengthUnit> likely_unit(double size, LengthUnit declared, double lowest, double highest) {
  for (const LengthUnit candidate : {LengthUnit::mm, LengthUnit::cm, LengthUnit::m}) {
    const double scaled = size / millimetres_per(declared) * millimetres_per(candidate);
    if (scaled >= lowest && scaled <= highest)
      return candidate;
  }
  return std::nullopt;
}

// Throws InputError, with the likely unit, if `size` (mm) is not between lowest and highest (mm).
void check_range(double size, double lowest, double highest, const std::string& what, LengthUnit unit,
                 const std::string& path) {
  if (size >= lowest && size <= highest)
    return;
  const std::optional<LengthUnit> likely = likely_unit(size, unit, lowest, highest);
  throw InputError("implausible scale for a coronary lumen", path,
                   what + " " + figure(size) + " mm with units " + text_of(unit) + ", expected " + figure(lowest) +
                       " to " + figure(highest) + " mm",
                   (likely
                        ? std::string("if the file is in ") + text_of(*likely) + ", declare units " + text_of(*likely)
                        : "check the units (--units, units in a case file)") +
                       "; if it is not, cut away what is no coronary artery");
}

// Refuses triangles whose point indices are out of range. VTK's readers do not check them.
void check_indices(vtkPolyData* data, const std::string& path) {
  for (vtkCellArray* cells : {data->GetPolys(), data->GetStrips()}) {
    vtkIdType n = 0;
    const vtkIdType* ids = nullptr;
    const auto refuse = [&](const std::string& value) {
      throw InputError("a triangle names a point that the file does not have", path,
                       value + "; the file has " + std::to_string(data->GetNumberOfPoints()) + " points",
                       "export the surface again, or as STL");
    };
    if (!cells->IsValid())
      refuse("the list of triangles contradicts itself");
    auto cell = vtk::TakeSmartPointer(cells->NewIterator());
    for (cell->GoToFirstCell(); !cell->IsDoneWithTraversal(); cell->GoToNextCell()) {
      cell->GetCurrentCell(n, ids);
      for (const vtkIdType* id = ids; id != ids + n; ++id)
        if (*id < 0 || *id >= data->GetNumberOfPoints())
          refuse("point " + std::to_string(*id) + " in triangle " + std::to_string(cell->GetCurrentCellId()));
    }
  }
}

// Reads a file of any kind as triangles in mm. Throws InputError for fewer than `fewest` triangles.
vtkSmartPointer<vtkPolyData> in_millimetres(const std::string& path, LengthUnit unit, const std::vector<int>& labels,
                                            vtkIdType fewest, std::optional<Vec3> inlet, std::vector<Repair>& repairs) {
  const double scale = millimetres_per(unit);
  if (inlet)
    inlet = *inlet / scale; // in the file's unit
  check_there(path);
  check_kind(path);
  vtkSmartPointer<vtkPolyData> read;
  try {
    read = read_by_suffix(path, labels, inlet, repairs);
  } catch (const std::bad_alloc&) {
    throw InputError("the file claims more than there is memory for", path,
                     std::to_string(std::filesystem::file_size(path)) + " bytes",
                     "export it again; of a mask, crop the volume to the lumen");
  }
  check_indices(read, path);
  auto triangulate = vtkSmartPointer<vtkTriangleFilter>::New();
  triangulate->SetInputData(read);
  triangulate->PassVertsOff();
  triangulate->PassLinesOff();
  triangulate->Update();
  vtkSmartPointer<vtkPolyData> data = triangulate->GetOutput();
  if (data->GetNumberOfCells() < fewest)
    throw InputError("no surface in the file", path, std::to_string(data->GetNumberOfCells()) + " triangles",
                     "export the lumen's wall as triangles (a centreline or a cloud of points is none); check that the "
                     "file is complete and holds a triangulated surface");
  auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(data->GetNumberOfPoints());
  for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i) {
    double x[3];
    data->GetPoint(i, x);
    if (!std::isfinite(x[0]) || !std::isfinite(x[1]) || !std::isfinite(x[2]))
      throw InputError("a coordinate is not a finite number", path,
                       "point " + std::to_string(i) + " (the first is 0) at " + figure(x[0]) + ", " + figure(x[1]) +
                           ", " + figure(x[2]),
                       "remove the point where the surface was made, and export it again");
    points->SetPoint(i, x[0] * scale, x[1] * scale, x[2] * scale);
  }
  data->SetPoints(points);
  if (vtkDataArray* edge = read->GetFieldData()->GetArray(voxel_edge_array); edge && is_mask_file(path)) {
    edge->SetTuple1(0, scale * edge->GetTuple1(0));
    data->GetFieldData()->AddArray(edge);
  }
  return data;
}

} // namespace

double voxel_edge(vtkPolyData* data) {
  vtkDataArray* edge = data->GetFieldData()->GetArray(voxel_edge_array);
  return edge ? edge->GetTuple1(0) : 0;
}

void check_diagonal(double diagonal_mm, LengthUnit unit, const std::string& path) {
  // The limits are half the length of the shortest stent, and the size of a heart with its aorta. A vessel in the wrong
  // unit may be within them; check_mean_radius finds it.
  check_range(diagonal_mm, 4, 500, "bounding diagonal", unit, path);
}

void check_mean_radius(double radius_mm, LengthUnit unit, const std::string& path) {
  // Mean radii of coronary arteries, even ectatic ones, are 0.6 to 3 mm. Declared in a wrong unit they are out of the
  // range below.
  check_range(radius_mm, 0.3, 6, "mean radius", unit, path);
}

vtkSmartPointer<vtkPolyData> read_triangles(const std::string& path, LengthUnit unit) {
  std::vector<Repair> repairs; // stays empty, since only masks cause repairs here
  return in_millimetres(path, unit, {}, 1, std::nullopt, repairs);
}

vtkSmartPointer<vtkPolyData> read_surface(const std::string& path, LengthUnit unit, const std::vector<int>& labels,
                                          std::vector<Repair>& repairs, const std::optional<Vec3>& inlet) {
  const auto data = in_millimetres(path, unit, labels, 4, inlet, repairs);
  check_diagonal(data->GetLength(), unit, path);
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

std::optional<Vec3> tagged_inlet(vtkPolyData* data) {
  constexpr int inlet = 1; // tag of the inlet's cap (docs/design.md)
  const Soup soup = soup_of(data);
  Vec3 sum = Vec3::Zero();
  double area = 0;
  for (std::size_t i = 0; i < soup.region.size(); ++i) {
    if (soup.region[i] != inlet)
      continue;
    const Vec3 a = vec(soup.points[soup.triangles[i][0]]), b = vec(soup.points[soup.triangles[i][1]]),
               c = vec(soup.points[soup.triangles[i][2]]);
    const double weight = (b - a).cross(Vec3(c - a)).norm();
    sum += weight * (a + b + c) / 3;
    area += weight;
  }
  return area > 0 ? std::optional<Vec3>(sum / area) : std::nullopt;
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
    throw InputError("the file cannot be read", path, "it cannot be opened, or reading stopped",
                     "check its permissions and its disk");
  std::string hex;
  for (unsigned int i = 0; i < length; ++i) {
    char text[3];
    std::snprintf(text, sizeof text, "%02x", bytes[i]);
    hex += text;
  }
  return hex;
}

} // namespace anatomy
