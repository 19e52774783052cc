// Fuzz target: reads scene.json and checks where its devices lie on a vessel of 30 mm with a side branch.
#include "tests/fuzz/target.hpp"
#include "vci/scene/checks/plausibility.hpp"
#include "vci/scene/files/scene_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace vci;
  static const std::map<std::string, Path> paths{{"main", Path({{0, 0, 0}, {0, 0, 12}, {0, 0, 30}}, 0)},
                                                 {"side", Path({{0, 0, 0}, {0, 0, 12}, {9, 0, 24}}, -12)}};
  tests::expect_answer(bytes, size,
                       [](const std::filesystem::path& file) { check_placements(read_scene(file), paths); });
  return 0;
}
