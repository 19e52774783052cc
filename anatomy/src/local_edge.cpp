#include "local_edge.hpp"
#include "remesh.hpp"
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <algorithm>
#include <set>

namespace anatomy {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;

// CGAL's remeshing tolerates edges of 0.8 to 1.33 of its target: at this step a level's edges suit its neighbour's.
constexpr double level_step = 0.85;
constexpr double good_corner = 30; // degrees
constexpr int most_mends = 30;

Vec3 centroid(const Mesh& mesh, Face f) {
  Vec3 sum = Vec3::Zero();
  for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
    sum += vec(mesh.point(v));
  return sum / 3;
}

struct Remesher {
  Mesh mesh;
  WallTree wall;
  double edge;
  const std::vector<Branch>& branches;
  const std::vector<ReferenceProfile>& profiles;

  double factor(Face f) const { return edge_factor(branches, profiles, centroid(mesh, f)); }

  // Faces of the wall, away from the rims, of at most this edge factor.
  std::vector<Face> faces_up_to(double limit) const {
    std::vector<Face> faces;
    for (Face f : mesh.faces())
      if (!touches_cap(mesh, f) && factor(f) <= limit)
        faces.push_back(f);
    return faces;
  }

  enum class Step { resize, collapse, relax };

  // Every step flips and relaxes; only `resize` splits and only `relax` does not collapse.
  void remesh(const std::vector<Face>& faces, double target, unsigned iterations, Step step) {
    RegionMap region = region_map(mesh);
    auto rim = mark_rims(mesh);
    const auto projected = [&](Vertex v) {
      for (Face f : mesh.faces_around_target(mesh.halfedge(v)))
        if (region[f] != 0)
          return mesh.point(v);
      return wall.nearest(mesh.point(v));
    };
    PMP::isotropic_remeshing(faces, target, mesh,
                             CGAL::parameters::number_of_iterations(iterations)
                                 .number_of_relaxation_steps(2)
                                 .do_split(step == Step::resize)
                                 .do_collapse(step != Step::relax)
                                 .edge_is_constrained_map(rim)
                                 .face_patch_map(region)
                                 .protect_constraints(false)
                                 .projection_functor(projected));
    mesh.remove_property_map(rim);
    mesh.collect_garbage();
  }

  std::pair<double, Face> worst() const {
    std::pair<double, Face> found{180, Face()};
    for (Face f : mesh.faces())
      if (const double corner = smallest_corner(mesh, f); corner < found.first && !touches_cap(mesh, f))
        found = {corner, f};
    return found;
  }

  std::vector<Face> around(Face f, int rings) const {
    std::set<Face> patch{f};
    for (int ring = 0; ring < rings; ++ring)
      for (Face g : std::vector<Face>(patch.begin(), patch.end()))
        for (Vertex v : mesh.vertices_around_face(mesh.halfedge(g)))
          for (Face k : mesh.faces_around_target(mesh.halfedge(v)))
            if (!touches_cap(mesh, k))
              patch.insert(k);
    return {patch.begin(), patch.end()};
  }

  // The levels' seams stay where they are while each level is resized, and leave a few edges too short for their place.
  // Those are collapsed, the worst triangle's first, until no corner is below good_corner; the best state is kept.
  void mend() {
    remesh(faces_up_to(1), edge, 8, Step::relax);
    auto [corner, face] = worst();
    double best_corner = corner;
    Mesh best = mesh;
    for (int k = 0; k < most_mends && corner < good_corner; ++k) {
      const Vec3 where = centroid(mesh, face);
      remesh(around(face, 1), factor(face) * edge, 1, Step::collapse);
      remesh(around(nearest_face(where), 5), edge, 4, Step::relax);
      std::tie(corner, face) = worst();
      if (corner > best_corner) {
        best_corner = corner;
        best = mesh;
      }
    }
    mesh = best;
  }

  Face nearest_face(const Vec3& p) const {
    return *std::min_element(mesh.faces().begin(), mesh.faces().end(), [&](Face f, Face g) {
      return (centroid(mesh, f) - p).squaredNorm() < (centroid(mesh, g) - p).squaredNorm();
    });
  }
};

} // namespace

double edge_factor(const std::vector<Branch>& branches, const std::vector<ReferenceProfile>& profiles, const Vec3& p) {
  const NearestAxis near = nearest_axis(branches, p);
  const Branch& branch = branches[near.branch];
  const double reference = 0.5 * profiles[near.branch].diameter(branch.s[near.sample]);
  return std::clamp(branch.radius[near.sample] / reference, smallest_edge_factor, 1.0);
}

Mesh refined_at_throats(const Mesh& mesh, const Mesh& surface, double edge, const std::vector<Branch>& branches,
                        const std::vector<ReferenceProfile>& profiles) {
  Remesher remesher{mesh, WallTree(surface), edge, branches, profiles};
  bool refined = false;
  for (double factor = level_step; factor > level_step * smallest_edge_factor; factor *= level_step) {
    const std::vector<Face> faces = remesher.faces_up_to(factor / std::sqrt(level_step));
    if (faces.empty())
      break;
    remesher.remesh(faces, factor * edge, 5, Remesher::Step::resize);
    refined = true;
  }
  if (!refined)
    return mesh;
  remesher.mend();
  check_remeshed(remesher.mesh, edge);
  return remesher.mesh;
}

} // namespace anatomy
