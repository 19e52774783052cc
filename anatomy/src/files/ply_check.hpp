// Checks a PLY file before VTK's reader reads it. That reader trusts the header, and crashes if the header is wrong.
#pragma once
#include <string>

namespace anatomy {

/// Throws InputError with the line or record unless the file is a sound PLY. The header has known types. Its elements
/// vertex (scalars x, y, z) and face (list vertex_indices or vertex_index) come before any others. The body has at
/// least as many numbers as the header promises, and no face names a vertex that is not there.
void check_ply(const std::string& path);

} // namespace anatomy
