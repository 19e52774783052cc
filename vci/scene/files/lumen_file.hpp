// The lumen surface with its arrays, read and written with VTK; shapes for pictures.
#pragma once
#include "vci/geometry/lumen.hpp"
#include <filesystem>
#include <string>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

namespace vci {

/// A lumen and the file's data set, kept because its other arrays are written again.
struct LumenFile : Lumen {
  vtkSmartPointer<vtkPolyData> data;
};

/// Throws common::InputError if the file, an array or the surface is not as docs/design.md says.
LumenFile read_lumen(const std::filesystem::path& file);

struct PointArray {
  std::string name;
  int components;
  std::vector<double> values;
};
PointArray vector_array(const std::string& name, const Vectors& values);
/// The lumen as read, with new positions and further point arrays.
void write_lumen(const std::filesystem::path& vtp, const std::filesystem::path& stl, const LumenFile& lumen,
                 const Vectors& points, const std::vector<PointArray>& arrays);
/// A surface, or a set of lines if `lines` is not empty, for pictures.
void write_shape(const std::filesystem::path& vtp, const Vectors& points, const Triangles& triangles,
                 const std::vector<std::vector<int>>& lines, const std::vector<PointArray>& arrays);

} // namespace vci
