// Reads the positions of a mask's voxels from header fields that VTK's readers ignore, and checks headers.
#pragma once
#include <Eigen/Dense>
#include <cstdint>
#include <string>

namespace anatomy {

/// Largest number of voxels along an axis: far more than any scanner gives, and the volume's bytes still fit in 64
/// bits.
constexpr std::int64_t largest_axis = 65535;

/// Affine from voxel index to the file's frame, from a NRRD header (space directions and origin, or spacings). Throws
/// InputError if the mask is not three-dimensional, a line cannot be read, or a field that VTK's reader needs is
/// missing.
Eigen::Matrix4d nrrd_affine(const std::string& path);

/// Affine from voxel index to the file's frame, from a MetaImage header (TransformMatrix, Offset, ElementSpacing and
/// their older names). Throws InputError if a line cannot be read.
Eigen::Matrix4d meta_affine(const std::string& path);

/// Throw InputError if a file is too short to hold `bytes` of voxels. The header or the suffix .gz says whether the
/// voxels are compressed. Compressed voxels of a MetaImage are unpacked as a check. VTK's readers accept a file of any
/// size, and leave missing voxels uninitialised.
void check_nrrd_length(const std::string& path, std::uintmax_t bytes);
void check_meta_length(const std::string& path, std::uintmax_t bytes);
void check_nifti_length(const std::string& path, std::uintmax_t bytes);

} // namespace anatomy
