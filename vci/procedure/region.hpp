// The part of the lumen that a procedure moves.
#pragma once
#include "vci/geometry/centreline.hpp"
#include "vci/geometry/lumen.hpp"
#include "vci/scene/scene.hpp"

namespace vci {

/// Flags the lumen vertices that may move: those of a device's branch up to the scene's region margin (mm) beyond its
/// ends, and those of other branches within this margin of the opened device.
std::vector<char> region_of_interest(const Lumen& lumen, const Scene& scene, const std::map<std::string, Path>& paths);

} // namespace vci
