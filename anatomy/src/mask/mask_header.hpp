// Where a mask's voxels lie, from the headers that VTK's readers leave unread.
#pragma once
#include <Eigen/Dense>
#include <cstdint>
#include <string>

namespace anatomy {

/// Most voxels along an axis: far above any scanner's, and the bytes of such a volume still hold in 64 bits.
constexpr std::int64_t largest_axis = 65535;

/// Voxel index to the file's frame of a NRRD header (space directions and origin, or spacings). Throws InputError where
/// it is not three-dimensional, a line cannot be read, or a field is missing without which VTK's reader goes astray.
Eigen::Matrix4d nrrd_affine(const std::string& path);

/// The same of a MetaImage header (TransformMatrix, Offset, ElementSpacing and their older names).
Eigen::Matrix4d meta_affine(const std::string& path);

/// Throws InputError if a file is too short to hold `bytes` of voxels, packed as its header (or .gz) says. VTK's
/// readers believe any size, and leave missing voxels uninitialised.
void check_nrrd_length(const std::string& path, std::uintmax_t bytes);
void check_meta_length(const std::string& path, std::uintmax_t bytes);
void check_nifti_length(const std::string& path, std::uintmax_t bytes);

} // namespace anatomy
