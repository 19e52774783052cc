// Rims, at which the wall meets the caps.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// The property "e:rim": edges between faces of different tags. The caller removes it.
Mesh::Property_map<Edge, bool> mark_rims(Mesh& mesh);

/// Whether a triangle has a vertex on a cap or its rim.
bool touches_cap(const Mesh& mesh, Face f);

} // namespace anatomy
