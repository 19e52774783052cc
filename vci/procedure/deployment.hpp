// Runs a scene's procedure on the mechanical system.
#pragma once
#include "vci/geometry/centreline.hpp"
#include "vci/geometry/lumen.hpp"
#include "vci/procedure/procedure.hpp"
#include "vci/procedure/stent_history.hpp"
#include "vci/wall/wall.hpp"

namespace vci {

struct StageReport {
  std::string step, stage;
  double seconds;
  RelaxResult result;
};

/// A device as it stands when it matters: a balloon inflated, a stent at the end.
struct DeviceShape {
  enum class Kind { balloon, stent } kind;
  std::string name; ///< a balloon's by its step, a stent's device
  Vectors points;
  Triangles triangles;
  Balance forces; ///< at these points, N
};

struct Deployment {
  std::vector<StageReport> stages;
  std::vector<StentHistory> stents;
  std::vector<DeviceShape> balloons;
  std::vector<std::string> switched_off, warnings;
  Vectors points;                    ///< lumen points at the end
  std::vector<double> wall_stretch;  ///< per lumen point: largest principal stretch
  std::vector<double> malapposition; ///< per lumen point: gap between wall and stent, mm; 0 where no stent faces it
  Balance forces;                    ///< per lumen point at the end, N; 0 where the wall is fixed
  std::map<std::string, Path> paths; ///< axes at the end
  int vertices = 0;                  ///< that took part in the wall
};

/// The state on the way, for pictures.
struct Snapshot {
  int stages_done, steps; ///< steps of the stage under way
  Vectors lumen;
  Balance forces; ///< per lumen point, N; empty amid a stage of textbook integration, as the devices' then
  std::vector<DeviceShape> devices;
};
/// Sees the state at the end of each stage and, where every_steps > 0, every so many steps.
struct Observer {
  std::function<void(const Snapshot&)> see;
  int every_steps = 0;
};

/// @param lumen, paths as read; progress goes to standard error.
/// Throws common::ComputationError naming step, stage, residual and remedy where a stage does not reach force balance.
Deployment deploy(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& paths,
                  const Observer* observer = nullptr);

} // namespace vci
