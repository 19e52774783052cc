// The part of the lumen that a procedure moves.
#pragma once
#include "vci/geometry/centreline.hpp"
#include "vci/geometry/lumen.hpp"
#include "vci/scene/scene.hpp"

namespace vci {

/// Flags the lumen vertices that may move: those within the scene's region margin (mm) of a device along its branch.
std::vector<char> region_of_interest(const Lumen& lumen, const Scene& scene, const std::map<std::string, Path>& paths);

} // namespace vci
