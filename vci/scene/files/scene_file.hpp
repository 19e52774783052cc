// Reads scene.json and checks it before any work.
#pragma once
#include "vci/scene/scene.hpp"

namespace vci {

/// Reads and checks a scene. Throws common::InputError naming file, key, value and remedy.
Scene read_scene(const std::filesystem::path& file);

/// Reads and checks a scene in memory, with the keys `patient`, `devices`, `procedure` and optionally `wall` and
/// `numerics`.
/// @param name name of the scene in messages, in place of a file's name
Scene scene_from(const nlohmann::json& entries, const std::string& name);

} // namespace vci
