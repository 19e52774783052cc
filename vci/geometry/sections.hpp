// Cross-sections of the lumen.
#pragma once
#include "vci/geometry/centreline.hpp"

namespace vci {

/// Unit normals of a surface's vertices.
Vectors section_normals(const Vectors& points, const Triangles& triangles);

/// Area (mm^2) of the loop that the plane cuts round its origin; the loop whose centroid is nearest to it is taken.
/// Returns 0 where the plane cuts no closed loop. The vertices are taken to lie on a smooth surface: arcs, not the
/// triangles' chords, bound the area, whose error falls with the fourth power of the edge instead of the second.
/// @param units section_normals() of the surface
double section_area(const Vectors& points, const Triangles& triangles, const Vectors& units, const Vec3& origin,
                    const Vec3& normal);

/// The smallest of the areas (mm^2) every half millimetre along a part of a path, of those that have a closed outline;
/// 0 where none has.
double smallest_section(const Vectors& points, const Triangles& triangles, const Path& path, double s_start,
                        double s_end);

} // namespace vci
