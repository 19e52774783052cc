// Checks a scene's placements against the vessel's branches, before any work.
#pragma once
#include "vci/geometry/centreline.hpp"
#include "vci/scene/scene.hpp"

namespace vci {

/// Throws common::InputError if a branch is missing, if a device or the reported segment reaches past its branch, or if
/// a balloon would open a stent beyond its maximal diameter.
void check_placements(const Scene& scene, const std::map<std::string, Path>& paths);

/// The place of a device in the scene for error messages: "FILE: scene.procedure[1].devices[0] (step NAME, DEVICE)".
/// @param step, device numbers of the step and of the device in it, from 0
std::string device_location(const Scene& scene, std::size_t step, std::size_t device);

} // namespace vci
