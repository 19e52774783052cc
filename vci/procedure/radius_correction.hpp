// Baseline without mechanics: the lumen takes the device's radius along the stented span.
#pragma once
#include "vci/geometry/centreline.hpp"
#include "vci/geometry/lumen.hpp"
#include "vci/scene/scene.hpp"

namespace vci {

/// Moves each wall point of the branch along its ray from the axis. Within each stent's span (each balloon's if there
/// is no stent) the radius becomes (1 - recoil) R(p). R(p) is the chart's radius of the largest balloon centred in the
/// span, recoil the maker's. Over 3 mm beyond the ends a cubic with zero end slopes leads back to the original radius.
Vectors correct_radius(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& paths);

} // namespace vci
