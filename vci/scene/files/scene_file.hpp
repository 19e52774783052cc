// Reads scene.json and checks it before any work.
#pragma once
#include "vci/scene/scene.hpp"

namespace vci {

/// Reads and checks a scene. Throws common::InputError naming file, key, value and remedy.
Scene read_scene(const std::filesystem::path& file);

/// The same of entries that are in memory: `patient`, `devices`, `procedure` and optionally `wall` and `numerics` of a
/// scene.
/// @param name of the scene in messages, where a file would be named
Scene scene_from(const nlohmann::json& entries, const std::string& name);

} // namespace vci
