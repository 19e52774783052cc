// The part of the lumen that a procedure moves.
#pragma once
#include "vci/geometry/centreline.hpp"
#include "vci/geometry/lumen.hpp"
#include "vci/scene/scene.hpp"

namespace vci {

/// Flags lumen vertices within the margin (mm) of a device's span along its branch.
std::vector<char> region_of_interest(const Lumen& lumen, const Scene& scene, const std::map<std::string, Path>& paths);

} // namespace vci
