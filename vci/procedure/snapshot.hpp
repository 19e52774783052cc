// Copies of the lumen and the devices, independent of the system that moves them.
#pragma once
#include "vci/procedure/run_state.hpp"

namespace vci {

/// The shape of a device. A DeploymentResult has balloons as fully inflated and stents as they are at the end.
struct DeviceShape {
  enum class Kind { balloon, stent } kind;
  /// In a DeploymentResult a balloon is named after its step, a stent after its device. In a Snapshot the names are
  /// "balloon" and "stent".
  std::string name;
  Vectors points; ///< mm
  Triangles triangles;
  Balance forces; ///< at these points, N
};

/// The state during a run or at its end, for pictures.
struct Snapshot {
  int stages_done, steps; ///< completed stages, and steps of the current or just completed stage
  Vectors lumen;          ///< mm
  Balance forces;         ///< per lumen point, N; within a stage of the textbook scheme all forces are empty
  std::vector<DeviceShape> devices;
};

/// The wall's forces (N) at all points of the lumen; 0 at points that are not in the computation.
Balance forces_on_lumen(const RunState& run, const Balance& forces);

/// The shape of a body with its part of the system's forces (N).
DeviceShape shape_of(const RunState& run, int body, const std::string& name, const Balance& forces);

/// A copy of the run's lumen and devices.
/// @param steps number of steps to report
/// @param forces on all vertices of the system, N; may be empty
Snapshot snapshot_of(const RunState& run, int stages_done, int steps, const Balance& forces);

} // namespace vci
