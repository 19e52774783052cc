// The gap between the wall and the stents that should lie against it.
#pragma once
#include "vci/mechanics/system.hpp"

namespace vci {

/// Per vertex of the wall (body 0): the gap (mm) to the smooth surface of the nearest of the bodies given that
/// faces it within 2 mm, 0 where none does.
std::vector<double> malapposition(const System& system, const std::vector<int>& stents);

} // namespace vci
