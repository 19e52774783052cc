// Finds the plane that cuts off the rounded rim of a flat end. Smoothing of a surface leaves such rims.
#pragma once
#include "core/slices.hpp"
#include "ends/planar_patches.hpp"
#include "ends/plane_cut.hpp"
#include <optional>

namespace anatomy {

/// Returns the plane behind the rounded rim of a flat end, parallel to the end. It is the nearest plane for which the
/// section half a radius further in is less than 5 % larger than its own. `section` is the area (mm2) half a radius
/// behind the end. Returns nothing if `section` is less than 1.1 of the end's area, or if the vessel goes on widening
/// for three quarters of a radius, as at a narrowed ostium.
std::optional<Plane> plane_behind_rim(const Slices& slices, const PatchPlane& end, double section);

} // namespace anatomy
