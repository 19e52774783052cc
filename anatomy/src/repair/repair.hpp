// Makes one oriented, manifold surface without holes in its wall from triangles as read. Its ends may be open.
#pragma once
#include "core/types.hpp"
#include "repair/loops.hpp"
#include <functional>
#include <optional>

namespace anatomy {

/// Whether the user says that the vessel ends at this loop.
using IsGivenEnd = std::function<bool(const Mesh&, const Loop&)>;

/// Welds points, drops degenerate and duplicate triangles and fins, orients, stitches, and keeps the largest component,
/// or, of those of comparable size, the one nearest to the `inlet` (mm). Others as long as a vessel are warned of.
/// Fills holes in the wall. A hole differs from a vessel's end in that the neighbouring faces lie in the loop's plane.
/// An end of the user stays open whatever its neighbours. Appends the changes to `repairs`. Throws InputError if
/// nothing usable remains.
Mesh repaired(const Soup& soup, std::vector<Repair>& repairs, const IsGivenEnd& is_given_end = {},
              const std::optional<Vec3>& inlet = {});

/// Removes self-intersections of a closed mesh (CGAL's local remeshing). Throws InputError with the place if some
/// remain.
void remove_self_intersections(Mesh& mesh, std::vector<Repair>& repairs);

/// Turns the normals of a closed mesh outward. Adds an entry to `repairs` if they pointed inward.
void orient_outward(Mesh& mesh, std::vector<Repair>& repairs);

/// Welding distance relative to the bounding diagonal.
constexpr double weld_tolerance = 2e-7;

} // namespace anatomy
