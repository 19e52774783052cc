// Makes a layer of the wall: a membrane or springs, as the wall's specification states.
#pragma once
#include "vci/mechanics/hencky_law.hpp"
#include "vci/mechanics/layer.hpp"
#include "vci/mechanics/system.hpp"
#include "vci/wall/wall_spec.hpp"

namespace vci {

/// Adds a layer to a body, by the model that `spec` names. The reference returned is valid as long as the body exists.
/// @param reference positions (mm) of the unstressed state
/// @param laws law of each triangle
const Layer& add_layer(System& system, int body, const WallSpec& spec, const Triangles& triangles,
                       const Vectors& reference, std::vector<HenckyLaw> laws);

} // namespace vci
