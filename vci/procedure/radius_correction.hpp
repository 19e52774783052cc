// Baseline without mechanics: the lumen takes the device's radius along the stented span.
#pragma once
#include "vci/geometry/centreline.hpp"
#include "vci/geometry/lumen.hpp"
#include "vci/scene/scene.hpp"

namespace vci {

/// Moves the points of the branch's wall straight away from or towards the axis, and returns all lumen points (mm).
/// Within the span of each stent the radius becomes (1 - recoil) R. R is the radius that the chart of the largest
/// balloon centred in the span gives at its pressure; the recoil is the maker's. In a scene without stents the spans
/// are those of the balloons, without recoil. Over 3 mm beyond the ends a cubic with zero end slopes leads back to the
/// original radius.
Vectors correct_radius(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& paths);

} // namespace vci
