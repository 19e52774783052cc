// The lumen surface with its arrays, read and written with VTK.
#pragma once
#include "vci/types.hpp"
#include <filesystem>
#include <string>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

namespace vci {

struct Lumen {
  Vectors points; ///< mm
  Triangles triangles;
  std::vector<int> region;           ///< per triangle: 0 wall, others caps
  std::vector<double> radius;        ///< local lumen radius, mm
  std::vector<double> plaque;        ///< plaque thickness, mm
  std::vector<int> plaque_type;      ///< 0 none, 1 fibrous, 2 lipid, 3 calcified
  vtkSmartPointer<vtkPolyData> data; ///< as read, with all its arrays
};

/// Throws common::InputError where the file, an array or the surface is not as docs/design.md says.
Lumen read_lumen(const std::filesystem::path& file);

struct PointArray {
  std::string name;
  int components;
  std::vector<double> values;
};
PointArray vector_array(const std::string& name, const Vectors& values);
/// The lumen as read, with new positions and further point arrays.
void write_lumen(const std::filesystem::path& vtp, const std::filesystem::path& stl, const Lumen& lumen,
                 const Vectors& points, const std::vector<PointArray>& arrays);
/// A surface or a set of lines (where `lines` is not empty) for pictures.
void write_shape(const std::filesystem::path& vtp, const Vectors& points, const Triangles& triangles,
                 const std::vector<std::vector<int>>& lines, const std::vector<PointArray>& arrays);

} // namespace vci
