#include "remesh/grading.hpp"
#include "core/crossings.hpp"
#include "core/faces.hpp"
#include "core/tags.hpp"
#include "ends/ends.hpp"
#include "remesh/angle_optimiser.hpp"
#include "remesh/remesh.hpp"
#include <algorithm>

namespace anatomy {
namespace {

// Ratio of the target edges of two successive levels. CGAL's remeshing accepts edges of 0.8 to 1.33 of its target, so
// the edges of a level suit the next level too.
constexpr double level_step = 0.85;
constexpr double good_angle = 30;    // degrees: a triangle with a smaller angle is remeshed
constexpr double aimed_angle = 30.5; // degrees: a margin over 30, which must remain after writing and reading
// A triangle is remeshed if the ratio of an edge to the wanted length is outside this range. Remeshing itself leaves
// one triangle in 10^4 outside.
constexpr double least_edge_ratio = 0.5;
constexpr double largest_edge_ratio = 1.6;
constexpr int rings_beside = 3;                 // this many rings of triangles round those to remesh are remeshed too
constexpr double off_wall = 1e-6;               // mm: a vertex farther from the wall is projected on it
constexpr double most_regraded_share = 1.0 / 3; // regraded() gives up if a larger share of the triangles is to remesh

// Whether a triangle has edges near the wanted length, and no angle below 30 degrees.
bool is_as_wanted(const Mesh& mesh, Face f, const SizingField& field) {
  const double length = field.at(centroid(mesh, f));
  for (Halfedge h : mesh.halfedges_around_face(mesh.halfedge(f))) {
    const double ratio = (vec(mesh.point(mesh.source(h))) - vec(mesh.point(mesh.target(h)))).norm() / length;
    if (ratio < least_edge_ratio || ratio > largest_edge_ratio)
      return false;
  }
  return smallest_angle(mesh, f) >= good_angle;
}

// Flags the faces of a compact mesh that are to be remeshed: those that are not is_as_wanted(), and three rings of
// faces round them. Faces that touch a cap are left out.
std::vector<bool> faces_to_remesh(const Mesh& mesh, const SizingField& field) {
  std::vector<bool> chosen(mesh.num_faces(), false);
  for (Face f : mesh.faces())
    chosen[f] = !touches_cap(mesh, f) && !is_as_wanted(mesh, f, field);
  for (int ring = 0; ring < rings_beside; ++ring) {
    const std::vector<bool> before = chosen;
    for (Face f : mesh.faces())
      if (before[f])
        for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
          for (Face g : mesh.faces_around_target(mesh.halfedge(v)))
            chosen[g] = chosen[g] || !touches_cap(mesh, g);
  }
  return chosen;
}

struct Remesher {
  Mesh mesh;
  const Mesh &original, &surface;
  const WallTree wall, original_wall; ///< the walls of `surface` and of `original`
  const SizingField& field;
  std::vector<bool> chosen; ///< for each face of `original`, whether it is remeshed; empty: all are

  Remesher(const Mesh& start, const Mesh& smooth, const SizingField& lengths)
      : mesh(start), original(start), surface(smooth), wall(smooth), original_wall(original), field(lengths) {}

  // The faces to remesh whose wanted edge is at most `length` (mm); faces that touch a cap are left out.
  std::vector<Face> faces_up_to(double length) const {
    std::vector<Face> faces;
    for (Face f : mesh.faces()) {
      if (touches_cap(mesh, f))
        continue;
      const Vec3 c = centroid(mesh, f);
      if (field.at(c) <= length && (chosen.empty() || chosen[original_wall.nearest_face(point(c))]))
        faces.push_back(f);
    }
    return faces;
  }

  // All faces, of caps too, whose wanted edge is at least `length` (mm).
  std::vector<Face> faces_with_wanted_edge_from(double length) const {
    std::vector<Face> faces;
    for (Face f : mesh.faces())
      if (field.at(centroid(mesh, f)) >= length)
        faces.push_back(f);
    return faces;
  }

  // Remeshes these faces to edges of `target` mm. Every iteration flips edges and relaxes vertices; with `resize` it
  // also splits and collapses edges.
  void remesh(const std::vector<Face>& faces, double target, unsigned iterations, bool resize) {
    remesh_faces(mesh, faces, target, iterations, wall, resize);
    // CGAL does not project new vertices on the border of the faces. Vertices on the wall keep their coordinates
    // exactly.
    for (Vertex v : mesh.vertices())
      if (const Point p = on_wall(mesh, v, wall); CGAL::squared_distance(p, mesh.point(v)) > off_wall * off_wall)
        mesh.point(v) = p;
  }

  // Remeshes level by level, from edges of `coarsest` mm to the finest. Each level is remeshed together with all finer
  // ones, so that the borders of two levels are far apart.
  void resize(double coarsest) {
    for (double target = coarsest;; target *= level_step) {
      const std::vector<Face> faces = faces_up_to(target == field.edge() ? target : target / std::sqrt(level_step));
      if (faces.empty())
        break;
      remesh(faces, target, 5, true);
    }
    const std::vector<Face> faces = faces_up_to(coarsest);
    if (!faces.empty())
      remesh(faces, coarsest, 3, false);
  }

  // Remeshes a mesh of edges of `uniform` mm. The finer levels come first, then the coarser ones upwards, each together
  // with all that are still coarser.
  void resize_both_ways(double uniform) {
    resize(level_step * uniform);
    for (double target = uniform / level_step;; target = std::min(target / level_step, field.edge())) {
      const std::vector<Face> faces = faces_with_wanted_edge_from(target * std::sqrt(level_step));
      if (!faces.empty())
        remesh(faces, target, 5, true);
      if (target == field.edge())
        break;
    }
    remesh(faces_up_to(field.edge()), field.edge(), 3, false);
    flatten_caps(mesh);
  }

  // The mesh with its self-intersections repaired and its angles widened. Angles stay as they are if every way to
  // widen them makes the surface cross itself.
  Mesh finished() {
    untangle(mesh);
    check_remeshed(mesh, field.edge());
    for (const auto& [passes, careful] : {std::pair{3, false}, {1, false}, {3, true}}) {
      Mesh widened = mesh;
      widen_angles(widened, surface, wall, aimed_angle, passes, careful);
      if (!crosses_itself(widened))
        return widened;
    }
    return mesh;
  }
};

} // namespace

Mesh graded(const Mesh& mesh, const Mesh& surface, const SizingField& field) {
  Remesher remesher(mesh, surface, field);
  remesher.resize(level_step * field.edge());
  return remesher.finished();
}

Mesh coarsened(const Mesh& mesh, double edge, const Mesh& surface, const SizingField& field) {
  Remesher remesher(mesh, surface, field);
  remesher.resize_both_ways(edge);
  return remesher.finished();
}

std::optional<Mesh> regraded(const Mesh& mesh, const Mesh& surface, const SizingField& field) {
  Remesher remesher(mesh, surface, field);
  remesher.chosen = faces_to_remesh(mesh, field);
  const auto count = static_cast<double>(std::count(remesher.chosen.begin(), remesher.chosen.end(), true));
  if (count > most_regraded_share * static_cast<double>(mesh.number_of_faces()))
    return std::nullopt;
  if (count > 0)
    remesher.resize(field.edge());
  return remesher.finished();
}

} // namespace anatomy
