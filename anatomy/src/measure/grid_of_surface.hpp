// Whether a surface was contoured on a grid, as that of a mask is, by where its vertices lie.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// Spacing (mm) of the grid on which a surface was contoured, the largest of the three axes of its coordinates; 0 if
/// there is none between 0.15 and 1.2 mm. Contouring puts each vertex on an edge of the grid, so that two of its three
/// coordinates are multiples of the spacing. Smoothing blurs this, but the vertices' density along each axis keeps a
/// wave of that length, which stands out of the waves beside it. It has to do so along every axis on which the surface
/// is 8 mm long, and along two of them. A grid that is turned against the axes is not found.
double grid_of_surface(const Mesh& mesh);

} // namespace anatomy
