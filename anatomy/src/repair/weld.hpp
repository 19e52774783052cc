// Steps of the repair that work on unconnected triangles, before they are a mesh.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// Merges points closer than `tolerance` (mm) and drops points that no triangle uses.
Soup welded(const Soup& soup, double tolerance, std::vector<Repair>& repairs);

/// Drops triangles with two equal corners. Of several triangles with the same corners it keeps the first.
void drop_degenerate_and_duplicate(Soup& soup, std::vector<Repair>& repairs);

/// Drops fins: triangles that have one edge in common with two or more others, and one edge in common with none.
void drop_fins(Soup& soup, std::vector<Repair>& repairs);

} // namespace anatomy
