// Limits how much a solver step may compress a triangle.
#pragma once
#include "vci/mechanics/system.hpp"

namespace vci {

/// Smallest stretch that one step may give a triangle: length after the step over length before it, of the line in the
/// triangle's plane that shortens most.
constexpr double least_step_stretch = 0.5;

/// Shortens the displacements of triangles that a step would compress below `least_step_stretch`. The linearised
/// equations of a step do not resist the collapse of a triangle. So a small triangle may lose its area or turn over in
/// a single step. Its forces are then meaningless, and the stage finds no balance. Such a triangle keeps its mean
/// displacement, and the displacements relative to the mean are halved until the limit holds. If one of its vertices is
/// fixed, the displacements themselves are halved. The triangles are treated once, in their order. So a later triangle
/// may change the displacement of a vertex that it shares with an earlier one.
/// @param dx displacements of the step, mm; shortened in place
/// @return number of triangles that were held back
int limit_compression(const System& system, Vectors& dx);

} // namespace vci
