// Frames along the z axis, for tests that place a device without a vessel.
#pragma once
#include "vci/devices/ring_grid.hpp"

namespace vci::tests {

/// One frame for each ring of the grid, at its place along z.
inline std::vector<Frame> straight_frames(const RingGrid& grid) {
  std::vector<Frame> frames;
  for (double s : grid.s)
    frames.push_back({Vec3(0, 0, s), Vec3::UnitZ(), Vec3::UnitX(), Vec3::UnitY()});
  return frames;
}

} // namespace vci::tests
