// Fuzz target: reads centreline.vtp and checks where a segment lies on it. A single branch is also checked against a
// straight tube of 16 mm with caps.
#include "tests/fuzz/target.hpp"
#include "tests/unit/vci/vessel.hpp"
#include "vci/scene/checks/lumen_check.hpp"
#include "vci/scene/checks/plausibility.hpp"
#include "vci/scene/files/centreline_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace vci;
  static const Lumen lumen = tests::Vessel{.length = 16}.closed();
  tests::expect_answer(bytes, size, [](const std::filesystem::path& file) {
    Scene scene;
    scene.centreline = file;
    scene.segment = Segment{"main", 4, 12};
    const auto paths = read_centreline(file);
    check_placements(scene, paths);
    if (paths.size() == 1) // the tube has no side branch
      check_lumen(scene, lumen, paths);
  });
  return 0;
}
