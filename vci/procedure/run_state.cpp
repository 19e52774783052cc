#include "vci/procedure/run_state.hpp"
#include "vci/procedure/region.hpp"

#include <algorithm>

namespace vci {

RunState::RunState(Scene of, Lumen before, std::map<std::string, Path> axes)
    : scene(std::move(of)), lumen(std::move(before)), paths(std::move(axes)) {
  const bool whole = scene.numerics.integrator.textbook;
  const std::vector<char> free =
      whole ? std::vector<char>(lumen.points.size(), 1) : region_of_interest(lumen, scene, paths);
  wall = add_wall(system, lumen, free, scene.wall, scene.map_pa);
}

bool RunState::is_stent(int body) const {
  return std::any_of(stents.begin(), stents.end(), [&](const StentHistory& h) { return h.stent.body == body; });
}

} // namespace vci
