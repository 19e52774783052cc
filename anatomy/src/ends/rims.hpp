// The rounded rims of flat ends, as smoothing leaves them.
#pragma once
#include "core/slices.hpp"
#include "ends/planar_patches.hpp"
#include "ends/plane_cut.hpp"
#include <optional>

namespace anatomy {

/// The plane behind the rounded rim of a flat end, across the end's normal. It is the nearest one whose section is
/// 5 % smaller, at the most, than the section half a radius further in. `section` is the area (mm2) half a radius
/// behind the end. None is returned if the end is about as large as that, or if the vessel goes on widening for three
/// quarters of a radius, as at a narrowed ostium.
std::optional<Plane> plane_behind_rim(const Slices& slices, const PatchPlane& end, double section);

} // namespace anatomy
