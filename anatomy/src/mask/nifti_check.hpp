// NIfTI headers that VTK's reader survives: it ends the program at dimensions that no image has.
#pragma once
#include <string>

namespace anatomy {

/// Throws InputError unless a NIfTI header, packed or not, has known dimensions and a known type of scalars.
void check_nifti_header(const std::string& path);

} // namespace anatomy
