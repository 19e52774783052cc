// Reads surface files: STL (ASCII or binary), VTP, PLY, OBJ; and labelled masks, from which a surface is made.
#pragma once
#include "core/types.hpp"
#include <optional>
#include <vector>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

namespace anatomy {

/// Triangles of a surface file, in mm, of any size. Throws as read_surface, except for the size.
vtkSmartPointer<vtkPolyData> read_triangles(const std::string& path, const std::string& units);

/// Reads a surface as triangles, in mm. Point and cell arrays of a VTP are kept.
/// units: "mm", "cm" or "m", the file's length unit. labels: of a mask (mask_file.hpp), none for its only one. Parts of
/// a mask that are left out are noted in `repairs`; the part with the `inlet` (mm) is kept, or else the largest. Throws
/// InputError: unknown suffix or unit, missing or unreadable file, no triangles, coordinates that are not finite, a
/// label for a file that is no mask, or a size that is not a coronary lumen's (with the likely unit).
vtkSmartPointer<vtkPolyData> read_surface(const std::string& path, const std::string& units,
                                          const std::vector<int>& labels, std::vector<Repair>& repairs,
                                          const std::optional<Vec3>& inlet = {});

/// The longest edge of the voxels (mm) of the mask that a surface was read from; 0 for other surfaces.
double voxel_edge(vtkPolyData* data);

/// The triangles and, if present, the cell array region_id.
Soup soup_of(vtkPolyData* data);

/// Centre of the triangles that the file itself tags as the inlet's cap (region_id 1), if it does.
std::optional<Vec3> tagged_inlet(vtkPolyData* data);

/// SHA-256 of a file's bytes, hexadecimal.
std::string sha256_of_file(const std::string& path);

/// Millimetres per unit; throws InputError for a unit other than mm, cm, m.
double millimetres_per(const std::string& units);

/// Throws InputError if a lumen of this bounding diagonal (mm) is not plausible (4 to 500 mm).
void check_diagonal(double diagonal_mm, const std::string& units, const std::string& path);

/// Throws InputError if the mean radius 2 V/A (mm) is not a coronary lumen's (0.3 to 6 mm).
void check_mean_radius(double radius_mm, const std::string& units, const std::string& path);

} // namespace anatomy
