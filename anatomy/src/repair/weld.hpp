// Steps of the repair that work on unconnected triangles, before they are a mesh.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// Merges points closer than `tolerance` (mm) and drops points that no triangle uses.
Soup welded(const Soup& soup, double tolerance, std::vector<Repair>& repairs);

/// Drops triangles with two equal corners and all but one of triangles with the same corners.
void drop_degenerate_and_duplicate(Soup& soup, std::vector<Repair>& repairs);

/// Drops fins: triangles with a non-manifold edge and a free one.
void drop_fins(Soup& soup, std::vector<Repair>& repairs);

} // namespace anatomy
