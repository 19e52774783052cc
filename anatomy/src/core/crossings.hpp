// Triangles of a surface that cross each other. CGAL's headers for them compile slowly: one file alone includes them.
#pragma once
#include "core/types.hpp"
#include <utility>

namespace anatomy {

/// All pairs of triangles that cross.
std::vector<std::pair<Face, Face>> crossings(const Mesh& mesh);

/// Whether any triangles cross: of the mesh, of some of its faces.
bool crosses_itself(const Mesh& mesh);
bool crosses_itself(const Mesh& mesh, const std::vector<Face>& faces);

/// Takes out the triangles that cross and fills the holes, as far as CGAL can. The caller checks what is left.
void replace_crossings(Mesh& mesh);

} // namespace anatomy
