#include "remesh/remesh.hpp"
#include "common/error.hpp"
#include "core/crossings.hpp"
#include "core/measures.hpp"
#include "core/tags.hpp"
#include "ends/ends.hpp"
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <algorithm>

namespace anatomy {
namespace PMP = CGAL::Polygon_mesh_processing;

Point on_wall(const Mesh& mesh, Vertex v, const WallTree& wall) {
  const RegionMap region = region_map(mesh);
  for (Face f : mesh.faces_around_target(mesh.halfedge(v)))
    if (region[f] != 0)
      return mesh.point(v);
  return wall.nearest(mesh.point(v));
}

void remesh_faces(Mesh& mesh, const std::vector<Face>& faces, double edge, unsigned iterations, const WallTree& wall,
                  bool resize) {
  RegionMap region = region_map(mesh);
  auto rim = mark_rims(mesh);
  // rims are not relaxed: they would shrink at every iteration until caps and wall cross
  PMP::isotropic_remeshing(faces, edge, mesh,
                           CGAL::parameters::number_of_iterations(iterations)
                               .number_of_relaxation_steps(2)
                               .do_split(resize)
                               .do_collapse(resize)
                               .edge_is_constrained_map(rim)
                               .face_patch_map(region)
                               .protect_constraints(false)
                               .projection_functor([&](Vertex v) { return on_wall(mesh, v, wall); }));
  mesh.remove_property_map(rim);
  mesh.collect_garbage();
}

namespace {

constexpr double narrow_angle = 30;          // degrees: a triangle with a smaller angle is narrow
constexpr double most_narrow_share = 0.1;    // share of narrow triangles above which the mesh is remeshed again
constexpr double loosening_edge_ratio = 0.6; // edge of the finer mesh in between, as a share of the wanted edge

void remesh_wall(Mesh& mesh, double edge, const WallTree& wall) {
  const auto faces = mesh.faces();
  remesh_faces(mesh, {faces.begin(), faces.end()}, edge, 8, wall);
}

bool is_narrow(const Mesh& mesh) {
  const auto faces = mesh.faces();
  const auto count =
      std::count_if(faces.begin(), faces.end(), [&](Face f) { return smallest_angle(mesh, f) < narrow_angle; });
  return static_cast<double>(count) > most_narrow_share * static_cast<double>(mesh.number_of_faces());
}

} // namespace

Mesh remeshed(const Mesh& mesh, double edge, const Mesh& surface) {
  Mesh out = mesh;
  const WallTree wall(surface);
  remesh_wall(out, edge, wall);
  // Remeshing may leave a regular loft unchanged: its long edges are short enough, and a collapse of its short edges
  // would make the others too long. Remeshing it to a finer mesh first avoids this.
  if (is_narrow(out)) {
    remesh_wall(out, loosening_edge_ratio * edge, wall);
    remesh_wall(out, edge, wall);
  }
  flatten_caps(out);
  untangle(out);
  check_remeshed(out, edge);
  return out;
}

void untangle(Mesh& mesh) {
  if (!crosses_itself(mesh))
    return;
  const auto on_caps = [](const Mesh& m) {
    const RegionMap region = region_map(m);
    return std::count_if(m.faces().begin(), m.faces().end(), [&](Face f) { return region[f] != 0; });
  };
  Mesh copy = mesh;
  replace_crossings(copy);
  // the surface must still be a topological sphere: then nothing has fused or torn
  const bool sound = CGAL::is_closed(copy) && !crosses_itself(copy) && on_caps(copy) == on_caps(mesh) &&
                     copy.number_of_vertices() + copy.number_of_faces() == copy.number_of_edges() + 2;
  if (sound)
    mesh = copy;
}

void check_remeshed(const Mesh& out, double edge) {
  if (!CGAL::is_closed(out))
    throw common::ComputationError("remeshing left the surface open", "remeshing", std::to_string(edge) + " mm",
                                   "try a smaller edge");
  const auto pairs = crossings(out);
  if (!pairs.empty())
    throw common::ComputationError("remeshing made the surface cross itself",
                                   point_text(vec(out.point(out.target(out.halfedge(pairs.front().first))))),
                                   std::to_string(pairs.size()) + " pairs of triangles at edge " +
                                       std::to_string(edge) + " mm",
                                   "use a smaller edge");
}

double smallest_angle(const Mesh& mesh, Face f) {
  double smallest = 180;
  for (Halfedge h : mesh.halfedges_around_face(mesh.halfedge(f))) {
    const Vec3 p = vec(mesh.point(mesh.target(h)));
    const Vec3 a = vec(mesh.point(mesh.source(h))) - p, b = vec(mesh.point(mesh.target(mesh.next(h)))) - p;
    smallest = std::min(smallest, std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / pi);
  }
  return smallest;
}

Quality quality_of(const Mesh& mesh) {
  Quality quality;
  quality.min_angle_deg = quality.min_angle_rim_deg = 180;
  quality.smallest_edge_mm = 1e300;
  for (Edge e : mesh.edges()) {
    const double length = (vec(mesh.point(mesh.vertex(e, 0))) - vec(mesh.point(mesh.vertex(e, 1)))).norm();
    quality.smallest_edge_mm = std::min(quality.smallest_edge_mm, length);
  }
  for (Face f : mesh.faces()) {
    const double angle = smallest_angle(mesh, f);
    quality.min_angle_rim_deg = std::min(quality.min_angle_rim_deg, angle);
    if (angle < quality.min_angle_deg && !touches_cap(mesh, f)) {
      quality.min_angle_deg = angle;
      quality.min_angle_at = vec(mesh.point(mesh.target(mesh.halfedge(f))));
    }
  }
  quality.volume_mm3 = enclosed_volume(mesh);
  return quality;
}

} // namespace anatomy
