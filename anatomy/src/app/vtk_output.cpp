#include "app/vtk_output.hpp"
#include "common/error.hpp"
#include "common/vtk/writing.hpp"
#include <cerrno>
#include <unistd.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkIntArray.h>
#include <vtkPointData.h>
#include <vtkSTLWriter.h>
#include <vtkStringArray.h>
#include <vtkXMLPolyDataWriter.h>

namespace anatomy {
namespace {

template <class Array, class Values> void add(vtkDataSetAttributes* to, const char* name, const Values& values) {
  vtkNew<Array> array;
  array->SetName(name);
  for (const auto value : values)
    array->InsertNextValue(value);
  to->AddArray(array);
}

} // namespace

vtkSmartPointer<vtkPolyData> lumen_data(const Mesh& mesh, const LumenArrays* arrays) {
  auto data = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (Vertex v : mesh.vertices())
    points->InsertNextPoint(mesh.point(v).x(), mesh.point(v).y(), mesh.point(v).z());
  vtkNew<vtkCellArray> cells;
  const RegionMap region = region_map(mesh);
  std::vector<int> regions;
  for (Face f : mesh.faces()) {
    cells->InsertNextCell(3);
    for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
      cells->InsertCellPoint(static_cast<vtkIdType>(v.idx()));
    regions.push_back(region[f]);
  }
  data->SetPoints(points);
  data->SetPolys(cells);
  add<vtkIntArray>(data->GetCellData(), "region_id", regions);
  if (arrays) {
    add<vtkIntArray>(data->GetCellData(), "branch_id", arrays->branch_id);
    add<vtkDoubleArray>(data->GetPointData(), "radius_mm", arrays->radius_mm);
    add<vtkDoubleArray>(data->GetPointData(), "reference_radius_mm", arrays->reference_radius_mm);
    add<vtkDoubleArray>(data->GetPointData(), "plaque_thickness_mm", arrays->plaque_thickness_mm);
    add<vtkIntArray>(data->GetPointData(), "plaque_type", arrays->plaque_type);
  }
  return data;
}

vtkSmartPointer<vtkPolyData> centreline_data(const std::vector<Branch>& branches) {
  auto data = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkCellArray> lines;
  vtkNew<vtkStringArray> names;
  names->SetName("branch_name");
  std::vector<int> ids;
  std::vector<double> s, radius, curvature, torsion;
  for (const Branch& branch : branches) {
    lines->InsertNextCell(static_cast<int>(branch.x.size()));
    for (const Vec3& x : branch.x)
      lines->InsertCellPoint(points->InsertNextPoint(x.data()));
    ids.push_back(branch.id);
    names->InsertNextValue(branch.name);
    s.insert(s.end(), branch.s.begin(), branch.s.end());
    radius.insert(radius.end(), branch.radius.begin(), branch.radius.end());
    curvature.insert(curvature.end(), branch.curvature.begin(), branch.curvature.end());
    torsion.insert(torsion.end(), branch.torsion.begin(), branch.torsion.end());
  }
  data->SetPoints(points);
  data->SetLines(lines);
  add<vtkIntArray>(data->GetCellData(), "branch_id", ids);
  data->GetCellData()->AddArray(names);
  add<vtkDoubleArray>(data->GetPointData(), "s_mm", s);
  add<vtkDoubleArray>(data->GetPointData(), "radius_mm", radius);
  add<vtkDoubleArray>(data->GetPointData(), "curvature_per_mm", curvature);
  add<vtkDoubleArray>(data->GetPointData(), "torsion_per_mm", torsion);
  return data;
}

void write_vtp(vtkPolyData* data, const std::filesystem::path& path) {
  vtkNew<vtkXMLPolyDataWriter> writer;
  writer->SetFileName(path.c_str());
  writer->SetInputData(data);
  if (!common::write_xml(writer.Get(), path)) {
    std::error_code none;
    std::filesystem::remove(path, none);
    throw common::WriteError(path.string());
  }
}

std::filesystem::path temporary_path(const std::filesystem::path& target) {
  return target.parent_path() / (".partial-" + std::to_string(getpid()) + "-" + target.filename().string());
}

void check_folder(const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::path there = fs::absolute(folder, error);
  while (!fs::exists(fs::symlink_status(there, error)) && there.has_relative_path())
    there = there.parent_path();
  const bool is_folder = fs::is_directory(there, error);
  if (!is_folder || access(there.c_str(), W_OK | X_OK) != 0)
    throw common::InputError("the folder for results cannot be written", folder,
                             there.string() +
                                 (is_folder ? ": " + std::generic_category().message(errno) : " is no folder"),
                             "name one that can be written");
}

void check_folder_of(const std::string& path) {
  std::error_code error;
  check_folder(std::filesystem::absolute(path, error).parent_path());
}

void make_folder_of(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::absolute(path, error).parent_path(), error);
  if (error)
    throw common::WriteError(path.string(), error.message());
}

void check_surface_file(const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension().string();
  if (ending != ".vtp" && ending != ".stl")
    throw common::InputError("unknown surface format", path, ending, "name a .vtp or .stl file");
  check_folder_of(path);
}

void write_surface(const Mesh& mesh, const std::string& path) {
  const std::filesystem::path target(path);
  check_surface_file(path);
  make_folder_of(target);
  const auto partial = temporary_path(target);
  const auto data = lumen_data(mesh, nullptr);
  if (target.extension() == ".vtp") {
    write_vtp(data, partial);
  } else {
    vtkNew<vtkSTLWriter> writer;
    writer->SetFileName(partial.c_str());
    writer->SetFileTypeToBinary();
    writer->SetInputData(data);
    if (!common::write_stl(writer.Get(), partial, data->GetNumberOfPolys()))
      throw common::WriteError(path);
  }
  std::error_code error;
  std::filesystem::rename(partial, target, error);
  if (error) // VTK could not open the file, for example, and does not report this
    throw common::WriteError(path, error.message());
}

} // namespace anatomy
