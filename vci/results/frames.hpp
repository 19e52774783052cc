// States on the way, written for an animation: a VTP file per surface and state, and a .pvd that lists them.
#pragma once
#include "vci/procedure/deployment.hpp"
#include "vci/scene/files/lumen_file.hpp"

#include <filesystem>
#include <sstream>

namespace vci {

/// Point arrays pressure_n, contact_n, foundation_n and residual_n (N); none where there are no forces.
std::vector<PointArray> force_arrays(const Balance& balance);

class FrameWriter {
public:
  /// Files go to `folder`, which is made; older frames in it are taken out.
  FrameWriter(std::filesystem::path folder, const LumenFile& lumen);
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
