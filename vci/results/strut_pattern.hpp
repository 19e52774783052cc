// The stent's struts for pictures: open-cell crowns with links, mapped onto the deployed grid.
#pragma once
#include "vci/devices/ring_grid.hpp"
#include "vci/devices/stent/stent_spec.hpp"

namespace vci {

/// Axes of the struts as lines, and round tubes of a strut's thickness about them as triangles.
struct Struts {
  Vectors points;
  std::vector<std::vector<int>> lines;
  Triangles triangles;
};
/// Draws wavy rows of struts, one about every 1.2 mm. Each row has the stent's number of crowns, and neighbouring rows
/// are joined by its number of links.
/// @param cylinder vertices of the deployed grid, mm
Struts strut_pattern(const StentSpec& spec, const RingGrid& grid, const Vectors& cylinder);

} // namespace vci
