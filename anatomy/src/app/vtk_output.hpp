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

/// Throws InputError if `folder` cannot be made or written to. It is called before the long computation.
void check_folder(const std::string& folder);

/// The same for the folder of a file.
void check_folder_of(const std::string& path);

/// Makes the folder of a file if it does not exist. Throws WriteError if it cannot be made.
void make_folder_of(const std::filesystem::path& path);

/// Throws InputError unless the name ends in .vtp or .stl and the file's folder can be made or written to.
void check_surface_file(const std::string& path);

/// Writes a tagged mesh as VTP (with region_id) or STL, by the suffix of `path`. Its folder is made if it does not
/// exist.
void write_surface(const Mesh& mesh, const std::string& path);

} // namespace anatomy
