// Cross-sections of the lumen.
#pragma once
#include "vci/types.hpp"

namespace vci {

/// Area (mm^2) of the loop that the plane cuts round its origin; the loop whose centroid is nearest to it is taken.
/// Returns 0 where the plane cuts no closed loop.
double section_area(const Vectors& points, const Triangles& triangles, const Vec3& origin, const Vec3& normal);

} // namespace vci
