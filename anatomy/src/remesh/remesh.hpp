// Uniform remeshing that keeps the caps' rims, and measures of the mesh's quality.
#pragma once
#include "core/wall_tree.hpp"

namespace anatomy {

/// A copy of the closed, tagged `mesh` with edges of about `edge` mm. Tags are kept and caps are flat. The wall's
/// vertices lie on the wall of `surface`, which is `mesh` itself or its curved refinement. Throws ComputationError if
/// the result crosses itself or is not closed.
Mesh remeshed(const Mesh& mesh, double edge, const Mesh& surface);

/// Remeshes `faces` to edges of `edge` mm (CGAL's isotropic remeshing). Rims stay; new vertices of the wall lie on
/// `wall`.
/// @param resize false: edges are flipped and vertices relaxed, but no edge is split or collapsed
void remesh_faces(Mesh& mesh, const std::vector<Face>& faces, double edge, unsigned iterations, const WallTree& wall,
                  bool resize = true);

/// The point to which v is projected: the nearest point of the wall. A vertex on a cap or a rim stays in its place.
Point on_wall(const Mesh& mesh, Vertex v, const WallTree& wall);

/// Repairs self-intersections of a closed, tagged mesh without changing its caps or its topology (CGAL's local
/// remeshing). A wall rougher than its edges has such intersections. If the repair fails the mesh is not changed.
void untangle(Mesh& mesh);

/// Throws ComputationError if the mesh, remeshed at `edge` mm, crosses itself or is not closed.
void check_remeshed(const Mesh& mesh, double edge);

/// Smallest angle of a triangle, degrees.
double smallest_angle(const Mesh& mesh, Face f);

struct Quality {
  double min_angle_deg = 0;         ///< smallest angle of a wall triangle away from the rims
  Vec3 min_angle_at = Vec3::Zero(); ///< its place, mm
  double min_angle_rim_deg = 0;     ///< smallest angle of all triangles
  double smallest_edge_mm = 0;
  double volume_mm3 = 0;
};
Quality quality_of(const Mesh& mesh);

} // namespace anatomy
