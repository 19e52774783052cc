// Cross-sections of the lumen.
#pragma once
#include "vci/geometry/centreline.hpp"

namespace vci {

/// Unit normals of a surface's vertices.
Vectors section_normals(const Vectors& points, const Triangles& triangles);

/// Area (mm^2) of the loop in which the plane cuts the surface round the plane's origin, by the nearest centroid.
/// Returns 0 if the plane cuts no closed loop. The vertices are taken as points of a smooth surface: arcs bound the
/// area, not chords of the triangles. Its error then falls with the fourth power of the edge, not the second.
/// @param units section_normals() of the surface
double section_area(const Vectors& points, const Triangles& triangles, const Vectors& units, const Vec3& origin,
                    const Vec3& normal);

/// The smallest area (mm^2) of the sections with a closed outline, every half millimetre along a part of a path; 0 if
/// no section has one.
double smallest_section(const Vectors& points, const Triangles& triangles, const Path& path, double s_start,
                        double s_end);

} // namespace vci
