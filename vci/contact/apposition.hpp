// The gap between the wall and the stents that should lie against it.
#pragma once
#include "vci/mechanics/system.hpp"

namespace vci {

/// A stent, and the part of the wall that it should lie against.
struct StentAtWall {
  int body;
  /// A flag for each vertex of the wall; empty flags all. Struts across the mouth of a side branch are no
  /// malapposition, nor is the wall beyond the stent's ends, which may face an end across a bend.
  std::vector<char> wall = {};
};

/// For each vertex of the wall (body 0), the gap (mm) to the smooth surface of the nearest stent that faces the vertex.
/// The gap is 0 if stent and wall touch, or if no stent faces the vertex within 5 mm.
std::vector<double> malapposition(const System& system, const std::vector<StentAtWall>& stents);

} // namespace vci
