// Limits by how much one solver step may compress a triangle.
#pragma once
#include "vci/mechanics/system.hpp"

namespace vci {

/// Smallest stretch of a triangle in one step: shortest length after the step over length before it, of all lines in
/// the triangle's plane.
constexpr double least_step_stretch = 0.5;

/// Shortens the displacements of triangles that a step would compress below `least_step_stretch`. A step is the
/// solution of equations linearised at its start. They know nothing of a triangle that collapses, so a small one may
/// lose its area or turn over in a single step. Its forces then mean nothing, and the stage finds no balance.
/// Such a triangle keeps its mean displacement; the displacements relative to the mean are halved until the limit
/// holds. A fixed vertex stays, so a triangle with one has all its displacements halved. One pass over the triangles,
/// in their order: a later triangle may change the displacement of a vertex that it shares with an earlier one.
/// @param dx displacements of the step, mm; shortened in place
/// @return number of triangles that were held back
int limit_compression(const System& system, Vectors& dx);

} // namespace vci
