// Whether lumen and centreline can be those of one vessel in which devices are placed, before any work.
#pragma once
#include "vci/geometry/centreline.hpp"
#include "vci/geometry/lumen.hpp"
#include "vci/scene/scene.hpp"

namespace vci {

/// Throws common::InputError (what, where, value, remedy) where the lumen's triangles are no oriented surface
/// (surface_check), face the axis, lie nowhere near `radius_mm` from it or are far too long; where the wall has a hole
/// or another number of ends than the tree of branches; where the main branch runs from an outlet to the inlet; where a
/// device or the reported segment reaches past the end of the lumen. Takes some ten milliseconds for 15 000 points.
void check_lumen(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& paths);

} // namespace vci
