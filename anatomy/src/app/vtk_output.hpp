// Turns surfaces and axes into VTK data, and writes them to files.
#pragma once
#include "app/arrays.hpp"
#include <filesystem>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

namespace anatomy {

/// The triangles with the cell array region_id and, unless null, the `arrays` (docs/design.md).
vtkSmartPointer<vtkPolyData> lumen_data(const Mesh& mesh, const LumenArrays* arrays);

/// A polyline per branch with the arrays s_mm, radius_mm, curvature_per_mm, torsion_per_mm, branch_id, branch_name.
vtkSmartPointer<vtkPolyData> centreline_data(const std::vector<Branch>& branches);

/// Writes `data` as a VTP file. Throws WriteError if the file cannot be written.
void write_vtp(vtkPolyData* data, const std::filesystem::path& path);

/// Path of a temporary file beside `target`, for writing until the file is complete. Its name has the number of the
/// process, so that two runs do not write to the same file.
std::filesystem::path temporary_path(const std::filesystem::path& target);

/// Throws InputError unless the folder of a file exists and can be written.
void check_folder_of(const std::string& path);

/// Throws InputError unless the name ends in .vtp or .stl and the file's folder exists and can be written.
void check_surface_file(const std::string& path);

/// Writes a tagged mesh as VTP (with region_id) or STL, by the suffix of `path`.
void write_surface(const Mesh& mesh, const std::string& path);

} // namespace anatomy
