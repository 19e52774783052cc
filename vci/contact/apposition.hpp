// The gap between the wall and the stents that should lie against it.
#pragma once
#include "vci/mechanics/system.hpp"

namespace vci {

/// For each vertex of the wall (body 0), the gap (mm) to the smooth surface of the nearest stent that faces the vertex.
/// The gap is 0 if stent and wall touch, or if no stent faces the vertex within 2 mm.
/// @param stents numbers of the stents' bodies
std::vector<double> malapposition(const System& system, const std::vector<int>& stents);

} // namespace vci
