#include "vci/procedure/run_state.hpp"
#include "vci/procedure/region.hpp"

#include <algorithm>

namespace vci {

RunState::RunState(Scene initial_scene, Lumen initial_lumen, std::map<std::string, Path> initial_paths)
    : scene(std::move(initial_scene)), lumen(std::move(initial_lumen)), paths(std::move(initial_paths)) {
  const bool whole = scene.numerics.integrator.textbook;
  const std::vector<char> may_move =
      whole ? std::vector<char>(lumen.points.size(), 1) : region_of_interest(lumen, scene, paths);
  wall = add_wall(system, lumen, may_move, scene.wall, scene.map_pa);
}

bool RunState::is_stent(int body) const {
  return std::any_of(stents.begin(), stents.end(), [&](const StentHistory& h) { return h.stent.body == body; });
}

} // namespace vci
