// Reads and checks the scene's settings of wall and numerics.
#pragma once
#include "vci/scene/files/checked_json.hpp"
#include "vci/scene/numerics.hpp"
#include "vci/wall/wall_spec.hpp"

namespace vci {

/// Read the scene's `wall` or `numerics`. Afterwards `entry.values_read` holds all settings, with defaults for missing
/// ones. Throw common::InputError, which names key, value and remedy.
WallSpec read_wall(CheckedObject& entry);
Numerics read_numerics(CheckedObject& entry);

/// Every setting of a scene's wall and numerics with its type or choices, limits and default, in the form of a JSON
/// schema.
nlohmann::json settings_table();

} // namespace vci
