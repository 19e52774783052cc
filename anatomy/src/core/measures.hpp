// Area, volume and mean radius of a surface. CGAL's headers for them compile slowly, so one file alone includes them.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// Area (mm2) of a face, of some faces, and of all faces.
double face_area(const Mesh& mesh, Face f);
double surface_area(const Mesh& mesh, const std::vector<Face>& faces);
double surface_area(const Mesh& mesh);

/// Volume (mm3) within a closed surface; negative if its normals point inward.
double enclosed_volume(const Mesh& mesh);

/// Twice the volume over the area (mm): the radius of a long tube of that volume and area.
double mean_radius(const Mesh& mesh);

/// Removes the vertices that belong to no face.
void remove_isolated_vertices(Mesh& mesh);

} // namespace anatomy
