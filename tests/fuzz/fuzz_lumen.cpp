// Fuzz target: reads lumen.vtp and checks it as the lumen of a straight vessel of 16 mm.
#include "tests/fuzz/target.hpp"
#include "vci/scene/checks/lumen_check.hpp"
#include "vci/scene/files/lumen_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace vci;
  static const std::map<std::string, Path> paths{{"main", Path({{0, 0, 0}, {0, 0, 8}, {0, 0, 16}}, 0)}};
  tests::expect_answer(bytes, size, [](const std::filesystem::path& file) {
    Scene scene;
    scene.lumen = file;
    check_lumen(scene, read_lumen(file), paths);
  });
  return 0;
}
