// Copies of the lumen and the devices, independent of the system that moves them.
#pragma once
#include "vci/procedure/run_state.hpp"

namespace vci {

/// The shape of a device: of a balloon when inflated, of a stent at the end.
struct DeviceShape {
  enum class Kind { balloon, stent } kind;
  std::string name; ///< of a balloon by its step, of a stent its device's name
  Vectors points;   ///< mm
  Triangles triangles;
  Balance forces; ///< at these points, N
};

/// An intermediate state, for pictures.
struct Snapshot {
  int stages_done, steps; ///< steps of the current stage
  Vectors lumen;          ///< mm
  Balance forces;         ///< per lumen point, N; empty, as the devices', within a stage of textbook integration
  std::vector<DeviceShape> devices;
};

/// Forces of the wall's vertices at all points of the lumen, 0 where the wall does not take part.
Balance on_lumen(const RunState& run, const Balance& forces);

DeviceShape shape_of(const RunState& run, int body, const std::string& name, const Balance& forces);

/// @param steps done in the stage under way @param forces of the system, N; may be empty
Snapshot snapshot_of(const RunState& run, int stages_done, int steps, const Balance& forces);

} // namespace vci
