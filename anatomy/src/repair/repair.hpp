// Makes one oriented, manifold surface without holes in its wall from triangles as read. Its ends may be open.
#pragma once
#include "core/types.hpp"
#include "repair/loops.hpp"
#include <functional>
#include <optional>

namespace anatomy {

/// Whether the user says that the vessel ends at this loop.
using IsGivenEnd = std::function<bool(const Mesh&, const Loop&)>;

/// Welds points; drops degenerate and duplicate triangles and fins; orients and stitches the rest. Keeps the largest
/// component or, with an `inlet` (mm), the one nearest to it among those with a fifth of the largest one's wall area.
/// Warns of other components as long as a vessel. Fills holes in the wall: loops whose neighbouring faces lie in the
/// loop's plane, unlike those of a vessel's end. A loop that the user names as an end stays open in any case. Appends
/// the changes to `repairs`. Throws InputError if nothing usable remains.
Mesh repaired(const Soup& soup, std::vector<Repair>& repairs, const IsGivenEnd& is_given_end = {},
              const std::optional<Vec3>& inlet = {});

/// Removes self-intersections of a closed mesh by CGAL's local repair. Throws InputError with a place if some remain.
void remove_self_intersections(Mesh& mesh, std::vector<Repair>& repairs);

/// Turns the normals of a closed mesh outward. Adds an entry to `repairs` if they pointed inward.
void orient_outward(Mesh& mesh, std::vector<Repair>& repairs);

/// Distance below which points are welded, over the diagonal of the bounding box.
constexpr double weld_tolerance = 2e-7;

} // namespace anatomy
