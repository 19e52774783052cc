// Finds the rims, the lines at which the wall meets the caps.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// Adds the property "e:rim" to the mesh: true for edges between faces of different tags. The caller removes it.
Mesh::Property_map<Edge, bool> mark_rims(Mesh& mesh);

/// Whether a corner of the triangle lies on a cap or on its rim.
bool touches_cap(const Mesh& mesh, Face f);

} // namespace anatomy
