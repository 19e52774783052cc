#include "vci/scene/files/lumen_file.hpp"
#include "common/error.hpp"
#include "common/vtk/writing.hpp"
#include "vci/scene/files/reading.hpp"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSTLWriter.h>
#include <vtkXMLPolyDataWriter.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace vci {

namespace {

vtkDataArray* required_array(vtkDataSetAttributes* attributes, const char* name, const std::filesystem::path& file) {
  vtkDataArray* array = attributes->GetArray(name);
  if (!array)
    throw common::InputError("the lumen lacks an array", file.string(), name, "make the lumen with the anatomy step");
  return array;
}

/// The whole number of a cell. Throws if the array holds something else.
int cell_number(vtkDataArray* array, vtkIdType cell, const std::filesystem::path& file) {
  const double value = array->GetComponent(cell, 0);
  if (array->GetNumberOfComponents() != 1 || std::abs(value) > 1e9 || value != std::floor(value)) {
    std::ostringstream found;
    found << array->GetName() << " of cell " << cell << ": " << value
          << ", components: " << array->GetNumberOfComponents();
    throw common::InputError("an array of the lumen's cells that is not of whole numbers", file.string(), found.str(),
                             "make the lumen with the anatomy step");
  }
  return static_cast<int>(value);
}

void add_arrays(vtkPolyData* data, const std::vector<PointArray>& arrays) {
  for (const PointArray& a : arrays) {
    vtkNew<vtkDoubleArray> array;
    array->SetName(a.name.c_str());
    array->SetNumberOfComponents(a.components);
    array->SetNumberOfTuples(data->GetNumberOfPoints());
    std::copy(a.values.begin(), a.values.end(), array->GetPointer(0));
    data->GetPointData()->AddArray(array);
  }
}

vtkSmartPointer<vtkPoints> vtk_points(const Vectors& points) {
  auto result = vtkSmartPointer<vtkPoints>::New();
  result->SetDataTypeToDouble();
  for (const Vec3& p : points)
    result->InsertNextPoint(p.data());
  return result;
}

void write_polydata(const std::filesystem::path& file, vtkPolyData* data) {
  vtkNew<vtkXMLPolyDataWriter> writer;
  writer->SetFileName(file.c_str());
  writer->SetInputData(data);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  if (!common::write_xml(writer.Get(), file))
    throw common::WriteError(file.string());
}

LumenFile load_lumen(const std::filesystem::path& file) {
  LumenFile lumen;
  lumen.data = read_polydata(file, "lumen");
  const vtkIdType n = lumen.data->GetNumberOfPoints(), m = lumen.data->GetNumberOfPolys();
  if (n == 0 || m == 0 || m != lumen.data->GetNumberOfCells())
    throw common::InputError("the lumen is not a surface of polygons", file.string(),
                             std::to_string(n) + " points, " + std::to_string(m) + " polygons",
                             "give a triangulated surface");
  vtkDataArray* region = required_array(lumen.data->GetCellData(), "region_id", file);
  vtkDataArray* radius = required_array(lumen.data->GetPointData(), "radius_mm", file);
  vtkDataArray* plaque = required_array(lumen.data->GetPointData(), "plaque_thickness_mm", file);
  vtkDataArray* type = required_array(lumen.data->GetPointData(), "plaque_type", file);
  for (vtkIdType i = 0; i < n; ++i) {
    Vec3 p;
    lumen.data->GetPoint(i, p.data());
    p = p.unaryExpr(&rounded_to_nanometre);
    const double r = rounded_to_nanometre(radius->GetTuple1(i)), t = rounded_to_nanometre(plaque->GetTuple1(i)),
                 k = type->GetTuple1(i);
    if (!p.allFinite() || p.norm() > 1e6 || !(r > 0.02 && r < 20) || !(t >= -0.1 && t < 20) || !(k >= 0 && k <= 3))
      throw common::InputError("a point of the lumen is not plausible (position, radius_mm, plaque)", file.string(),
                               "point " + std::to_string(i) + ": radius " + std::to_string(r) + ", plaque " +
                                   std::to_string(t) + ", type " + std::to_string(k),
                               "radii lie between 0.02 and 20 mm, plaque types between 0 and 3; check the units");
    lumen.points.push_back(p);
    lumen.radius.push_back(r);
    lumen.plaque.push_back(std::max(t, 0.0)); // interpolation may have made it slightly negative
    lumen.plaque_type.push_back(static_cast<int>(std::lround(k)));
  }
  if (vtkDataArray* reference = lumen.data->GetPointData()->GetArray("reference_radius_mm"))
    for (vtkIdType i = 0; i < n; ++i)
      lumen.reference_radius.push_back(rounded_to_nanometre(reference->GetTuple1(i)));
  vtkDataArray* branch = lumen.data->GetCellData()->GetArray("branch_id");
  vtkCellArray* polys = lumen.data->GetPolys();
  for (vtkIdType k = 0; k < m; ++k) {
    vtkIdType size;
    const vtkIdType* ids;
    polys->GetCellAtId(k, size, ids);
    if (size != 3)
      throw common::InputError("the lumen has a polygon that is no triangle", file.string(),
                               "polygon " + std::to_string(k), "triangulate the surface");
    if (std::any_of(ids, ids + size, [&](vtkIdType id) { return id < 0 || id >= n; }))
      throw common::InputError("a cell that names a point which is not there", file.string(),
                               "cell " + std::to_string(k), "the file is damaged: write it anew");
    lumen.triangles.push_back({static_cast<int>(ids[0]), static_cast<int>(ids[1]), static_cast<int>(ids[2])});
    lumen.region.push_back(cell_number(region, k, file));
    if (branch)
      lumen.branch.push_back(cell_number(branch, k, file));
  }
  return lumen;
}

} // namespace

LumenFile read_lumen(const std::filesystem::path& file) {
  return guarded_read(file, [&] { return load_lumen(file); });
}

PointArray vector_array(const std::string& name, const Vectors& values) {
  PointArray a{name, 3, {}};
  for (const Vec3& v : values)
    a.values.insert(a.values.end(), v.data(), v.data() + 3);
  return a;
}

void write_lumen(const std::filesystem::path& vtp, const std::filesystem::path& stl, const LumenFile& lumen,
                 const Vectors& points, const std::vector<PointArray>& arrays) {
  vtkNew<vtkPolyData> data;
  data->ShallowCopy(lumen.data);
  data->SetPoints(vtk_points(points));
  add_arrays(data, arrays);
  write_polydata(vtp, data);
  vtkNew<vtkSTLWriter> writer;
  writer->SetFileName(stl.c_str());
  writer->SetInputData(data);
  writer->SetFileTypeToBinary();
  if (!common::write_stl(writer.Get(), stl, data->GetNumberOfPolys()))
    throw common::WriteError(stl.string());
}

void write_shape(const std::filesystem::path& vtp, const Vectors& points, const Triangles& triangles,
                 const std::vector<std::vector<int>>& lines, const std::vector<PointArray>& arrays) {
  vtkNew<vtkPolyData> data;
  data->SetPoints(vtk_points(points));
  vtkNew<vtkCellArray> polygons, polylines;
  for (const Triangle& t : triangles)
    polygons->InsertNextCell({t[0], t[1], t[2]});
  for (const auto& line : lines) {
    polylines->InsertNextCell(static_cast<int>(line.size()));
    for (int v : line)
      polylines->InsertCellPoint(v);
  }
  data->SetPolys(polygons);
  data->SetLines(polylines);
  add_arrays(data, arrays);
  write_polydata(vtp, data);
}

} // namespace vci
