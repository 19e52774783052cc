// Reads and checks the balloons and stents of a scene file.
#pragma once
#include "vci/devices/balloon/balloon_spec.hpp"
#include "vci/devices/stent/stent_spec.hpp"

#include <nlohmann/json.hpp>

namespace vci {

/// Read an entry of the scene's `devices`. Throw common::InputError, which names key, value and remedy.
/// @param where place of the entry in the file, for messages
BalloonSpec read_balloon(const nlohmann::json& entry, const std::string& where);
StentSpec read_stent(const nlohmann::json& entry, const std::string& where);
/// Throws common::InputError if the stent cannot have been crimped on the balloon, because of length or diameter.
void check_stent_on_balloon(const StentSpec& stent, const BalloonSpec& balloon, const std::string& where);

} // namespace vci
