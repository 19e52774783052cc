// Tells from the places of its vertices whether a surface was contoured on a grid, such as the voxels of a mask.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// Spacing (mm) of the grid on which a surface was contoured, the largest over the three coordinate axes. 0 if no grid
/// of 0.15 to 1.2 mm is found. Contouring puts each vertex on an edge of the grid, so two of its three coordinates are
/// multiples of the spacing. Smoothing blurs this. But the density of the vertices along each axis keeps a wave of
/// that wavelength, which is much stronger than waves of nearly the same wavelength. Such a wave is required along
/// every axis on which the surface extends over 8 mm, and along two axes at least. A grid turned against the axes is
/// not found.
double grid_of_surface(const Mesh& mesh);

} // namespace anatomy
