// Tells which end is the inlet, and which branch leads to each outlet.
#pragma once
#include "core/types.hpp"
#include <nlohmann/json.hpp>
#include <optional>

namespace anatomy {

/// Index of the inlet: the end nearest to the point `inlet` (mm) if given, else the end of the largest area. Throws
/// InputError if the point is farther than three radii of that end from it, or if there are fewer than two ends.
std::size_t inlet_of(const std::vector<End>& ends, const std::optional<Vec3>& inlet);

/// Which end is the inlet, and the branch id of each end (0 main, 1 side1, ...; the inlet's is -1).
struct Naming {
  std::size_t inlet = 0;
  std::vector<int> branch; ///< empty: build_tree() numbers the branches
};

/// The naming of an earlier state of the same vessel, whose anatomy.json is `like`. Each end gets the role (inlet or
/// outlet), the branch and the extension of the nearest end of that state. Throws InputError if the numbers of ends
/// differ or if two ends are nearest to the same one.
Naming naming_from_earlier(std::vector<End>& ends, const nlohmann::json& like);

/// The naming by points (mm) that the user gave. inlet_of() finds the inlet. Each point of `outlets` names the end near
/// it, the first one the outlet of `main`. Without `outlets` only the inlet is named. Throws InputError if a point is
/// not near an end, if two points are near the same end, or if an outlet has no point.
Naming naming_from_points(const std::vector<End>& ends, const std::optional<Vec3>& inlet,
                          const std::vector<Vec3>& outlets);

} // namespace anatomy
