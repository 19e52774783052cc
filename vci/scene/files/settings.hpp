// The scene's settings of wall and numerics, checked.
#pragma once
#include "vci/scene/files/checked_json.hpp"
#include "vci/scene/numerics.hpp"
#include "vci/wall/wall_spec.hpp"

namespace vci {

/// Read an entry; its `used` then contains the settings with defaults filled in.
/// Throw common::InputError naming key, value and remedy.
WallSpec read_wall(CheckedObject& entry);
Numerics read_numerics(CheckedObject& entry);

/// Every setting of a scene's wall and numerics with its type or choices, limits and default, as a JSON schema has
/// them.
nlohmann::json settings_table();

} // namespace vci
