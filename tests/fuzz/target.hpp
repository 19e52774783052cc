// Shared by the fuzz targets: a file in memory, and the check that a reader answers or refuses.
#pragma once
#include "common/error.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <sys/mman.h>
#include <unistd.h>

namespace vci::tests {

/// A file in memory with these bytes. Readers open it by its path, but it is not on a disk.
class FileInMemory {
public:
  FileInMemory(const std::uint8_t* bytes, std::size_t size) : descriptor_(memfd_create("fuzz", 0)) {
    for (std::size_t done = 0; done < size;) {
      const ssize_t written = write(descriptor_, bytes + done, size - done);
      if (written <= 0)
        throw std::runtime_error("no file in memory");
      done += static_cast<std::size_t>(written);
    }
  }
  ~FileInMemory() { close(descriptor_); }
  FileInMemory(const FileInMemory&) = delete;
  FileInMemory& operator=(const FileInMemory&) = delete;
  std::filesystem::path path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

private:
  int descriptor_;
};

/// How many files were read without a refusal.
inline std::size_t files_read = 0;

/// Calls a reader on a file of these bytes. It must answer, or refuse with an InputError that names a remedy. Any other
/// exception escapes.
template <class Read> void expect_answer(const std::uint8_t* bytes, std::size_t size, Read&& read) {
  const FileInMemory file(bytes, size);
  try {
    read(file.path());
    ++files_read;
  } catch (const common::InputError& refusal) {
    if (!std::strstr(refusal.what(), "remedy:"))
      throw;
  }
}

} // namespace vci::tests
