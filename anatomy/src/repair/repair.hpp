// Makes one oriented, manifold surface without holes in its wall from triangles as read. Its ends may be open.
#pragma once
#include "core/types.hpp"
#include "repair/loops.hpp"
#include <functional>
#include <optional>

namespace anatomy {

/// Whether the user says that the vessel ends at this loop.
using IsGivenEnd = std::function<bool(const Mesh&, const Loop&)>;

/// Welds points, drops degenerate and duplicate triangles and fins, then orients and stitches the rest. Keeps the
/// largest component or, with an `inlet` (mm), the component nearest to that point. Only components with a fifth of the
/// largest one's wall area are candidates for the latter. Warns of other components that may be vessels. Fills holes in
/// the wall: loops whose neighbouring faces lie in the loop's plane, as they do not at a vessel's end. A loop that the
/// user names as an end stays open. Appends the changes to `repairs`. Throws InputError if nothing usable remains.
Mesh repaired(const Soup& soup, std::vector<Repair>& repairs, const IsGivenEnd& is_given_end = {},
              const std::optional<Vec3>& inlet = {});

/// Removes self-intersections of a closed mesh by CGAL's local repair. Throws InputError with a place if some remain.
void remove_self_intersections(Mesh& mesh, std::vector<Repair>& repairs);

/// Turns the normals of a closed mesh outward. Adds an entry to `repairs` if they pointed inward.
void orient_outward(Mesh& mesh, std::vector<Repair>& repairs);

/// Points nearer to each other than this share of the bounding box's diagonal are welded.
constexpr double weld_tolerance = 2e-7;

} // namespace anatomy
