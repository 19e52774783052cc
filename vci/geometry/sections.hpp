// Cross-sections of the lumen.
#pragma once
#include "vci/geometry/centreline.hpp"

namespace vci {

/// Unit normals of a surface's vertices.
Vectors section_normals(const Vectors& points, const Triangles& triangles);

/// Area (mm^2) of the closed loop in which a plane cuts the surface. Of several loops, the one with the centroid
/// nearest to `origin` counts. Returns 0 if there is no closed loop. The vertices are taken as points of a smooth
/// surface: arcs bound the area instead of the triangles' chords. The area's error then falls with the fourth power of
/// the edge length, not the second.
/// @param unit_normals section_normals() of the surface
/// @param origin, normal point and unit normal of the plane
double section_area(const Vectors& points, const Triangles& triangles, const Vectors& unit_normals, const Vec3& origin,
                    const Vec3& normal);

/// The smallest area (mm^2) of sections at every half millimetre along a path from s_start to s_end (mm). Only sections
/// with a closed outline count; 0 if there is none.
double smallest_section(const Vectors& points, const Triangles& triangles, const Path& path, double s_start,
                        double s_end);

} // namespace vci
