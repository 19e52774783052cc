// Reads surface files: STL (ASCII or binary), VTP, PLY and OBJ. From a labelled mask it makes the surface.
#pragma once
#include "core/types.hpp"
#include "files/length_unit.hpp"
#include <optional>
#include <vector>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

namespace anatomy {

/// Reads a surface file as triangles in mm, whatever their extent. Throws the same errors as read_surface, but accepts
/// any size and needs one triangle only.
vtkSmartPointer<vtkPolyData> read_triangles(const std::string& path, LengthUnit unit);

/// Reads a surface as triangles in mm. Point and cell arrays of a VTP are kept.
/// @param unit the file's length unit
/// @param labels labels of a mask that are taken together; empty for its only label (mask/mask_file.hpp)
/// @param repairs takes a note of the parts of a mask that are left out
/// @param inlet a point (mm) in the part of a mask that is kept; without it the largest part is kept
/// Throws InputError for an unknown suffix, a missing or unreadable file, fewer than 4 triangles, or a
/// coordinate that is not finite. It also throws for a label if the file is no mask, and for a size that no coronary
/// lumen has, naming the likely unit.
vtkSmartPointer<vtkPolyData> read_surface(const std::string& path, LengthUnit unit, const std::vector<int>& labels,
                                          std::vector<Repair>& repairs, const std::optional<Vec3>& inlet = {});

/// The longest edge (mm) of the voxels of the mask that a surface was read from; 0 for other surfaces.
double voxel_edge(vtkPolyData* data);

/// The points and triangles of `data` and, if present, its cell array region_id.
Soup soup_of(vtkPolyData* data);

/// Centre (mm) of the triangles that the file itself tags as the inlet's cap (region_id 1), or nothing without such a
/// tag.
std::optional<Vec3> tagged_inlet(vtkPolyData* data);

/// SHA-256 of a file's bytes, hexadecimal.
std::string sha256_of_file(const std::string& path);

/// Throws InputError if this bounding diagonal (mm) is not plausible for a lumen (4 to 500 mm). `unit` is the declared
/// one.
void check_diagonal(double diagonal_mm, LengthUnit unit, const std::string& path);

/// Throws InputError if the mean radius 2 V/A (mm) is not a coronary lumen's (0.3 to 6 mm).
void check_mean_radius(double radius_mm, LengthUnit unit, const std::string& path);

} // namespace anatomy
