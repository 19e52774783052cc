// From triangles as read to one oriented, manifold surface without holes in its wall (its ends may be open).
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// Welds, drops degenerate and duplicate triangles and fins, orients, stitches, keeps the largest component, fills
/// holes in the wall (a loop whose neighbouring faces lie in the loop's plane; the ends of a vessel do not).
/// Appends what was done to `repairs`. Throws InputError if nothing usable remains.
Mesh repaired(const Soup& soup, std::vector<Repair>& repairs);

/// Removes self-intersections of a closed mesh (CGAL's local remeshing). Throws InputError with the place if some
/// remain.
void remove_self_intersections(Mesh& mesh, std::vector<Repair>& repairs);

/// Turns a closed mesh outward; reports it if it was inward.
void orient_outward(Mesh& mesh, std::vector<Repair>& repairs);

/// Welding distance relative to the bounding diagonal.
constexpr double weld_tolerance = 2e-7;

} // namespace anatomy
