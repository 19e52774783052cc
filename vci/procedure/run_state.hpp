// The state of a running procedure: the mechanical system, devices, contacts and history.
#pragma once
#include "vci/devices/balloon/balloon.hpp"
#include "vci/geometry/centreline.hpp"
#include "vci/geometry/lumen.hpp"
#include "vci/procedure/stent_history.hpp"
#include "vci/scene/scene.hpp"
#include "vci/solver/integrator.hpp"
#include "vci/wall/wall.hpp"

#include <map>

namespace vci {

struct RunState {
  /// Adds the wall to the system. Keeps the scene, and lumen and axes as they are before the procedure.
  RunState(Scene initial_scene, Lumen initial_lumen, std::map<std::string, Path> initial_paths);
  RunState(const RunState&) = delete;
  RunState& operator=(const RunState&) = delete;

  bool is_stent(int body) const;
  /// Current positions of all lumen points, mm.
  Vectors current_lumen() const { return current_lumen_points(lumen, wall, system); }

  const Scene scene;
  const Lumen lumen;
  const std::map<std::string, Path> paths;
  System system; ///< body 0 is the wall; stents follow in the order of their steps; balloons come last
  Wall wall;
  Interactions interactions;
  Balance balance; ///< forces at the end of the last stage
  std::vector<Balloon> balloons;
  std::vector<StentHistory> stents;
};

} // namespace vci
