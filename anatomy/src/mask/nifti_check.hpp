// Checks NIfTI headers before VTK's reader, which crashes on impossible dimensions.
#pragma once
#include <string>

namespace anatomy {

/// Throws InputError unless a NIfTI header, compressed or not, gives a single volume with a known type of scalars.
void check_nifti_header(const std::string& path);

} // namespace anatomy
