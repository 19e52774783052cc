// Checks OBJ files before VTK's reader, which does not check the indices of their faces.
#pragma once
#include <string>

namespace anatomy {

/// Throws InputError with the line if a corner of a face names a point, texture coordinate or normal that the file
/// lacks. Corners are v, v/vt, v//vn or v/vt/vn, counted from 1, or backwards from -1.
void check_obj(const std::string& path);

} // namespace anatomy
