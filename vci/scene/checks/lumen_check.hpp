// Checks, before any work, that lumen and centreline can belong to one vessel, and that devices lie within its ends.
#pragma once
#include "vci/geometry/centreline.hpp"
#include "vci/geometry/lumen.hpp"
#include "vci/scene/scene.hpp"

namespace vci {

/// Throws common::InputError, which names the fault, its place, the value and a remedy, for any of these faults:
/// - the lumen's triangles are not one oriented surface (surface_check), face the axis, or have far too long edges;
/// - the wall's distance from the axis does not fit `radius_mm`;
/// - the wall has a hole, or other ends than the branches of the centreline;
/// - the main branch runs from an outlet to the inlet;
/// - a device or the reported segment reaches past the end of the lumen.
/// The check takes some twenty milliseconds for 15 000 points.
void check_lumen(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& paths);

} // namespace vci
