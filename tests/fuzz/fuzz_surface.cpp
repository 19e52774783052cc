// Fuzz target: reads a surface or mask in any format that the anatomy accepts. The first byte of the input chooses the
// format.
#include "files/surface_file.hpp"
#include "tests/fuzz/target.hpp"

#include <array>
#include <vtkObject.h>

namespace {

// In the order of SUFFIXES in tests/fuzz/surface_corpus.py.
constexpr std::array<const char*, 7> suffixes{".stl", ".vtp", ".ply", ".obj", ".nii", ".nrrd", ".mha"};

// A symbolic link with the format's suffix to the file in memory, whose own name has no suffix.
class Named {
public:
  Named(const std::filesystem::path& file, const char* suffix)
      : path_(std::filesystem::temp_directory_path() / ("vci_fuzz_" + std::to_string(getpid()) + suffix)) {
    std::filesystem::remove(path_);
    std::filesystem::create_symlink(file, path_);
  }
  ~Named() { std::filesystem::remove(path_); }
  Named(const Named&) = delete;
  Named& operator=(const Named&) = delete;
  std::string path() const { return path_.string(); }

private:
  std::filesystem::path path_;
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size == 0)
    return 0;
  vtkObject::GlobalWarningDisplayOff();
  const char* suffix = suffixes[bytes[0] % suffixes.size()];
  vci::tests::expect_answer(bytes + 1, size - 1, [suffix](const std::filesystem::path& file) {
    const Named named(file, suffix);
    std::vector<anatomy::Repair> repairs;
    anatomy::read_surface(named.path(), anatomy::LengthUnit::mm, {}, repairs);
  });
  return 0;
}
