// The scene's settings of wall and numerics, checked.
#pragma once
#include "vci/scene/numerics.hpp"
#include "vci/wall/wall_spec.hpp"

#include <nlohmann/json.hpp>

namespace vci {

/// @param where place of the entry, for messages
/// @param used set to the settings with defaults filled in
/// Throw common::InputError naming key, value and remedy.
WallSpec read_wall(const nlohmann::json& entry, const std::string& where, nlohmann::json& used);
Numerics read_numerics(const nlohmann::json& entry, const std::string& where, nlohmann::json& used);

} // namespace vci
