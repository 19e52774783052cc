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
/// Zigzag rows of `crowns` crowns, one about every 1.2 mm, joined by `links` links; `cylinder` holds the grid's
/// vertices.
Struts strut_pattern(const StentSpec& spec, const RingGrid& grid, const Vectors& cylinder);

} // namespace vci
