// Writes intermediate states for an animation: a VTP file for each surface and state, and a .pvd file that lists them.
#pragma once
#include "vci/procedure/deployment.hpp"
#include "vci/scene/files/lumen_file.hpp"

#include <filesystem>
#include <sstream>

namespace vci {

/// The forces as point arrays pressure_n, contact_n, foundation_n and residual_n (N). Empty if there are no forces.
std::vector<PointArray> force_arrays(const Balance& balance);

class FrameWriter {
public:
  /// @param folder folder of the files; it is created, and frames of an earlier run in it are removed
  FrameWriter(std::filesystem::path folder, const LumenFile& lumen);
  /// Writes a file for the lumen and one for each device.
  void add(const Snapshot& snapshot);
  /// Writes frames.pvd, which ParaView opens as an animation.
  void finish() const;

private:
  std::filesystem::path folder_;
  const LumenFile& lumen_;
  std::ostringstream entries_;
  int count_ = 0;
};

} // namespace vci
