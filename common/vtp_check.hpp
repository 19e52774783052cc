// Checks that a .vtp file holds as much data as it claims, since VTK's reader trusts the claims.
#pragma once
#include <filesystem>
#include <string>

namespace common {

/// Throws InputError, in which `what` is the name of the file, in two cases: the file's elements are not those of one
/// piece of polydata, or an array has less text, bytes or compressed blocks than its element claims. Arrays may be
/// ascii, base64 or raw, inline or appended, compressed or not. Reads every array once. VTK's reader does not check the
/// claims: it allocates memory for any count, divides by zero, or follows null pointers.
void check_vtp(const std::filesystem::path& file, const std::string& what);

} // namespace common
