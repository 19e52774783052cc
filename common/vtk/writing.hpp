// Checks whether VTK wrote a file, since VTK's writers report success even after a failed write.
#pragma once
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace common {

/// Runs a writer of VTK's XML files. False if its error code says that it failed, or if the file lacks its last tag.
template <class Writer> bool write_xml(Writer* writer, const std::filesystem::path& file) {
  constexpr std::streamoff last_bytes = 32;
  if (!writer->Write() || writer->GetErrorCode() != 0)
    return false;
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  const std::streamoff size = stream.tellg();
  if (size < last_bytes)
    return false;
  std::string end(last_bytes, ' ');
  stream.seekg(size - last_bytes);
  return stream.read(end.data(), last_bytes) && end.find("</VTKFile>") != std::string::npos;
}

/// Runs a writer of binary STL files. False if its error code says that it failed, or if the file is too short.
template <class Writer> bool write_stl(Writer* writer, const std::filesystem::path& file, std::int64_t triangles) {
  constexpr std::int64_t header_bytes = 84, triangle_bytes = 50;
  if (!writer->Write() || writer->GetErrorCode() != 0)
    return false;
  std::error_code ignored;
  return static_cast<std::int64_t>(std::filesystem::file_size(file, ignored)) ==
         header_bytes + triangle_bytes * triangles;
}

} // namespace common
