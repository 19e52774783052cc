// Whether a .vtp file holds what it claims to hold, before VTK's reader takes its word for it.
#pragma once
#include <filesystem>
#include <string>

namespace common {

/// Throws InputError, which calls the file `what`, where a .vtp file's elements are not those of one piece of
/// polydata. The same where an array's text, bytes or compressed blocks are fewer than its element claims. Arrays may
/// be ascii, base64 or raw, inline or appended, compressed or not. Reads every array once. VTK's reader would make room
/// for whatever is claimed, divide by it, or follow null pointers where it gives up.
void check_vtp(const std::filesystem::path& file, const std::string& what);

} // namespace common
