// Finds the plane that cuts off the rounded rim of a flat end. Smoothing of a surface leaves such rims.
#pragma once
#include "core/slices.hpp"
#include "ends/planar_patches.hpp"
#include "ends/plane_cut.hpp"
#include <optional>

namespace anatomy {

/// Returns the plane behind the rounded rim of a flat end, parallel to the end. It is the nearest plane for which the
/// section half a radius further in is hardly larger than its own. Returns nothing if the section half a radius behind
/// the end is hardly larger than the end, or if the vessel goes on widening for three quarters of a radius, as at a
/// narrowed ostium, or bends back across the plane. Sizes are compared by `growth`, so a bend behind the end does not
/// count as widening.
std::optional<Plane> plane_behind_rim(const Slices& slices, const PatchPlane& end);

} // namespace anatomy
