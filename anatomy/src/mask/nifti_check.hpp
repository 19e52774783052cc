// Checks NIfTI headers before VTK's reader, which crashes on impossible dimensions.
#pragma once
#include <string>

namespace anatomy {

/// Throws InputError unless a NIfTI header, packed or not, has known dimensions and a known type of scalars.
void check_nifti_header(const std::string& path);

} // namespace anatomy
