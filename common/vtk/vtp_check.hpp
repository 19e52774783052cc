// Checks that a .vtp file holds as much data as it claims, since VTK's reader trusts the claims.
#pragma once
#include <filesystem>
#include <string>

namespace common {

/// Throws InputError in two cases: the elements are not those of polydata at one time step, or an array holds less
/// text, bytes or compressed blocks than its element claims. VTK's reader does not check the claims: it allocates
/// memory for any count, divides by zero, or follows null pointers. Reads every array once. Arrays may be ascii, base64
/// or raw, inline or appended, compressed or not.
/// @param what the file's content in words, for the message, for example "surface"
void check_vtp(const std::filesystem::path& file, const std::string& what);

} // namespace common
