// scene.json: what to deploy where, checked before any work.
#pragma once
#include "vci/scene/scene.hpp"

namespace vci {

/// Reads and checks a scene. Throws common::InputError naming file, key, value and remedy.
Scene read_scene(const std::filesystem::path& file);

} // namespace vci
