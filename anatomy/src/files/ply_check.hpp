// Checks PLY files before VTK's reader, which trusts their header and crashes if the header is wrong.
#pragma once
#include <string>

namespace anatomy {

/// Throws InputError with the line or record unless the file is a sound PLY. The header has known types. Its elements
/// vertex (scalars x, y, z) and face (list vertex_indices or vertex_index) come before any others. The body has as many
/// numbers as the header promises, and no face names a vertex that is not there.
void check_ply(const std::string& path);

} // namespace anatomy
