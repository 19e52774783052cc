// The gap between the wall and the stents that should lie against it.
#pragma once
#include "vci/mechanics/system.hpp"

namespace vci {

/// Gap (mm) per vertex of the wall (body 0) to the smooth surface of the nearest of `stents` that faces it within 2 mm;
/// 0 if none does.
std::vector<double> malapposition(const System& system, const std::vector<int>& stents);

} // namespace vci
