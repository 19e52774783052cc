// Reads and writes the lumen surface with its arrays, and writes shapes of devices and struts for pictures. Uses VTK.
#pragma once
#include "vci/geometry/lumen.hpp"
#include <filesystem>
#include <string>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

namespace vci {

/// A lumen with the data set of its file. Further arrays of the data set are written again with the results.
struct LumenFile : Lumen {
  vtkSmartPointer<vtkPolyData> data;
};

/// Reads a lumen. Throws common::InputError if the file, an array or the surface is not as docs/design.md states.
LumenFile read_lumen(const std::filesystem::path& file);

/// A named array with `components` values for each point.
struct PointArray {
  std::string name;
  int components;
  std::vector<double> values;
};
PointArray vector_array(const std::string& name, const Vectors& values);
/// Writes the lumen as read, with new positions (mm) and further point arrays, as .vtp and .stl.
void write_lumen(const std::filesystem::path& vtp, const std::filesystem::path& stl, const LumenFile& lumen,
                 const Vectors& points, const std::vector<PointArray>& arrays);
/// Writes triangles and lines (lists of points' indices) with point arrays as .vtp, for pictures.
void write_shape(const std::filesystem::path& vtp, const Vectors& points, const Triangles& triangles,
                 const std::vector<std::vector<int>>& lines, const std::vector<PointArray>& arrays);

} // namespace vci
