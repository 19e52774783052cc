// OBJ files as VTK's reader expects them: it takes the indices of their faces as they are.
#pragma once
#include <string>

namespace anatomy {

/// Throws InputError with the line unless every corner of every face (v, v/vt, v//vn or v/vt/vn, counted from 1, or
/// backwards from -1) names a point, texture coordinate and normal that the file has.
void check_obj(const std::string& path);

} // namespace anatomy
