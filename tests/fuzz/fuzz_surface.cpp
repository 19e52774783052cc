// Fuzz target: reads a surface or mask in any format that the anatomy accepts. The first byte of the input chooses the
// format. With the environment variable VCI_FUZZ_SUFFIX, such as .stl, the format is always that one.
#include "files/surface_file.hpp"
#include "tests/fuzz/target.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <vtkObject.h>

namespace {

// In the order of SUFFIXES in tests/fuzz/surface_corpus.py.
constexpr std::array<const char*, 7> suffixes{".stl", ".vtp", ".ply", ".obj", ".nii", ".nrrd", ".mha"};

// The suffix of the format that every input has; null where the first byte of an input chooses it.
const char* only_suffix() {
  const char* name = std::getenv("VCI_FUZZ_SUFFIX");
  if (name == nullptr)
    return nullptr;
  const auto* found =
      std::find_if(suffixes.begin(), suffixes.end(), [name](const char* one) { return !std::strcmp(one, name); });
  if (found == suffixes.end())
    throw std::invalid_argument(std::string("no format with the suffix ") + name);
  return *found;
}

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
  static const char* const only = only_suffix();
  const char* suffix = only != nullptr ? only : suffixes[bytes[0] % suffixes.size()];
  vci::tests::expect_answer(bytes + 1, size - 1, [suffix](const std::filesystem::path& file) {
    const Named named(file, suffix);
    std::vector<anatomy::Repair> repairs;
    anatomy::read_surface(named.path(), anatomy::LengthUnit::mm, {}, repairs);
  });
  return 0;
}
