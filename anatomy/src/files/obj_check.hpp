// Checks an OBJ file before VTK's reader reads it. That reader does not check the indices of the file's faces.
#pragma once
#include <string>

namespace anatomy {

/// Throws InputError with the line if a corner of a face names a point, texture coordinate or normal that the file
/// lacks. Corners are v, v/vt, v//vn or v/vt/vn, counted from 1, or backwards from -1.
void check_obj(const std::string& path);

} // namespace anatomy
