// Whether a surface was contoured on a grid, as from a mask, by the places of its vertices.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// Spacing (mm) of the grid on which a surface was contoured, the largest over the three coordinate axes; 0 if there is
/// none between 0.15 and 1.2 mm. Contouring puts each vertex on an edge of the grid, so two of its three coordinates
/// are multiples of the spacing. Smoothing blurs this. But the density of the vertices along each axis keeps a wave of
/// that length, which stands out among waves of nearly the same length. A grid counts if its wave stands out along
/// every axis on which the surface is 8 mm long, at least two. A grid that is turned against the axes is not found.
double grid_of_surface(const Mesh& mesh);

} // namespace anatomy
