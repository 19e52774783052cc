// Surfaces and axes as VTK data.
#pragma once
#include "app/arrays.hpp"
#include <filesystem>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

namespace anatomy {

/// The triangles with region_id and, if given, the arrays of docs/design.md.
vtkSmartPointer<vtkPolyData> lumen_data(const Mesh& mesh, const Arrays* arrays);

/// A polyline per branch with s_mm, radius_mm, curvature_per_mm, torsion_per_mm, branch_id, branch_name.
vtkSmartPointer<vtkPolyData> centreline_data(const std::vector<Branch>& branches);

/// Throws InputError if the file cannot be written.
void write_vtp(vtkPolyData* data, const std::filesystem::path& path);

/// Path beside `target` for writing it before it is complete. It has the process's number, so that two runs differ.
std::filesystem::path partial_of(const std::filesystem::path& target);

/// Throws InputError unless the name ends in .vtp or .stl.
void check_surface_name(const std::string& path);

/// Writes a tagged mesh as VTP (region_id) or STL by its suffix.
void write_surface(const Mesh& mesh, const std::string& path);

} // namespace anatomy
