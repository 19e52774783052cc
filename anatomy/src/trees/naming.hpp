// Which end is the inlet and which branch each outlet ends.
#pragma once
#include "core/types.hpp"
#include <nlohmann/json.hpp>
#include <optional>

namespace anatomy {

/// Index of the inlet: nearest to `inlet` if given, else the largest. Throws InputError if the point is farther than
/// three radii from every end, or if there are fewer than two ends.
std::size_t inlet_of(const std::vector<End>& ends, const std::optional<Vec3>& inlet);

/// Which end is the inlet, and the branch id of each end (0 main, 1 side1, ...; the inlet's is -1).
struct Naming {
  std::size_t inlet = 0;
  std::vector<int> branch; ///< empty: the tree decides
};

/// The naming of an earlier state, whose anatomy.json is `like`. Each end takes name and extension of the nearest end
/// there. Throws InputError if the numbers of ends differ or two ends match the same one.
Naming naming_like(std::vector<End>& ends, const nlohmann::json& like);

/// The naming by points (mm) that the user gave. The inlet is as by inlet_of. Each of `outlets` names the end near it;
/// the first is the outlet of `main`. Throws InputError if a point is not near an end, or if an outlet has no point.
Naming naming_given(const std::vector<End>& ends, const std::optional<Vec3>& inlet, const std::vector<Vec3>& outlets);

} // namespace anatomy
