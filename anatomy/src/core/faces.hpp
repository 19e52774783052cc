// Measures of single triangles.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// The triangle's unit normal times its area (mm2). Seen from the normal's side the corners run anticlockwise.
Vec3 area_vector(const Mesh& mesh, Face f);

/// Mean of the triangle's corners (mm).
Vec3 centroid(const Mesh& mesh, Face f);

} // namespace anatomy
