// Balloons and stents of a scene file, checked.
#pragma once
#include "vci/devices/balloon/balloon_spec.hpp"
#include "vci/devices/stent/stent_spec.hpp"

#include <nlohmann/json.hpp>

namespace vci {

/// Throw common::InputError naming key, value and remedy.
/// @param where place of the entry, for messages
BalloonSpec read_balloon(const nlohmann::json& entry, const std::string& where);
StentSpec read_stent(const nlohmann::json& entry, const std::string& where);
/// Throws common::InputError if a stent cannot have been crimped on a balloon.
void check_mounted(const StentSpec& stent, const BalloonSpec& balloon, const std::string& where);

} // namespace vci
