// Finds and replaces triangles of a surface that cross each other. CGAL's headers for this compile slowly, so only
// crossings.cpp includes them.
#pragma once
#include "core/types.hpp"
#include <utility>

namespace anatomy {

/// All pairs of triangles that cross each other.
std::vector<std::pair<Face, Face>> crossings(const Mesh& mesh);

/// Whether any two triangles of the mesh cross each other. With `faces`, only these are compared with each other.
bool crosses_itself(const Mesh& mesh);
bool crosses_itself(const Mesh& mesh, const std::vector<Face>& faces);

/// Removes triangles that cross and fills the holes that this leaves, as far as CGAL can. The caller checks whether
/// crossings are left.
void replace_crossings(Mesh& mesh);

} // namespace anatomy
