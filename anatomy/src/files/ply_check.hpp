// PLY files as VTK's reader expects them: it trusts their header, and ends the program where that lies.
#pragma once
#include <string>

namespace anatomy {

/// Throws InputError with the line or record unless the file is a sound PLY: a header of known types with the elements
/// vertex (scalars x, y, z) and face (list vertex_indices or vertex_index) before any others, and in its body as many
/// numbers as it promises and no vertex that is not there.
void check_ply(const std::string& path);

} // namespace anatomy
