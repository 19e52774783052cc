// Area, volume and mean radius of a surface. CGAL's headers for them compile slowly, so only measures.cpp includes
// them.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// Area (mm2) of one face, of the given faces, and of all faces.
double face_area(const Mesh& mesh, Face f);
double surface_area(const Mesh& mesh, const std::vector<Face>& faces);
double surface_area(const Mesh& mesh);

/// Volume (mm3) within a closed surface; negative if the normals point inward.
double enclosed_volume(const Mesh& mesh);

/// Mean radius (mm) of the vessels within a closed surface: 2 volume / area. For a long tube this is the tube's radius.
double mean_radius(const Mesh& mesh);

/// Removes the vertices that belong to no face.
void remove_isolated_vertices(Mesh& mesh);

} // namespace anatomy
