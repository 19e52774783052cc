// Makes a layer of the wall: a membrane or springs, as the wall's specification says.
#pragma once
#include "vci/mechanics/hencky_law.hpp"
#include "vci/mechanics/layer.hpp"
#include "vci/mechanics/system.hpp"
#include "vci/wall/wall_spec.hpp"

namespace vci {

/// Adds a layer to a body by the wall model that its spec names; it lives as long as the body.
/// @param reference positions of the unstressed state; @param laws per triangle.
const Layer& add_layer(System& system, int body, const WallSpec& spec, const Triangles& triangles,
                       const Vectors& reference, std::vector<HenckyLaw> laws);

} // namespace vci
