#include "remesh/angle_optimiser.hpp"
#include "core/crossings.hpp"
#include "core/faces.hpp"
#include "core/tags.hpp"
#include "remesh/remesh.hpp"
#include <CGAL/boost/graph/Euler_operations.h>
#include <algorithm>
#include <functional>
#include <set>

namespace anatomy {
namespace {

constexpr double pass_tolerance = 0.4; // degrees; no pass follows if the smallest angle is short of the goal by less
constexpr int moving_rings = 2;        // rings of vertices round a narrow triangle that may move
constexpr int most_sweeps = 6;         // largest number of times that each of these vertices is moved
constexpr int step_directions = 6;     // directions tried for each step of a vertex
constexpr double first_step = 0.2;     // length of a vertex's first step, in mean edge lengths at the vertex
constexpr int step_halvings = 4;       // number of step lengths tried, each half of the one before
// A change is kept only if the smallest angle of the neighbourhood gains more than this, degrees.
constexpr double least_gain = 0.05;
constexpr double least_move = 1e-3; // degrees; a vertex moves only if the smallest angle round it gains more
constexpr double cos_turned = 0.5;  // 60 degrees: a move may not turn a triangle by more
constexpr double cos_folded = 0.3;  // 73 degrees: a triangle steeper than this to the smooth wall is folded
constexpr double cos_crease = -0.5; // 120 degrees between two neighbours' normals: sharper than any carina of a lumen
constexpr std::size_t most_changes = 400; // largest number of triangles that are treated in one pass

Vec3 normal_at(const Mesh& mesh, Vertex v) {
  Vec3 sum = Vec3::Zero();
  for (Face f : mesh.faces_around_target(mesh.halfedge(v)))
    sum += area_vector(mesh, f);
  return sum.normalized();
}

// Whether the vertex may move: no triangle at it belongs to a cap.
bool may_move(const Mesh& mesh, Vertex v) {
  const RegionMap region = region_map(mesh);
  for (Face f : mesh.faces_around_target(mesh.halfedge(v)))
    if (region[f] != 0)
      return false;
  return true;
}

// The triangles round a vertex, and their normals before the vertex moves.
struct Star {
  std::vector<Face> faces;
  std::vector<Vec3> normals;
};

// The smallest angle (degrees) of the star's triangles. To save time the search stops at the first angle that is not
// above `enough`, and returns that one. It returns -1 at a triangle that has turned by more than 60 degrees.
double smallest_star_angle(const Mesh& mesh, const Star& star, double enough) {
  double angle = 180;
  for (std::size_t i = 0; i < star.faces.size() && angle > enough; ++i) {
    if (area_vector(mesh, star.faces[i]).normalized().dot(star.normals[i]) < cos_turned)
      return -1;
    angle = std::min(angle, smallest_angle(mesh, star.faces[i]));
  }
  return angle;
}

// Moves v along the wall so that the smallest angle of the triangles round it becomes as wide as possible. It is a
// pattern search: steps in several directions, of falling length. Returns whether v was moved.
bool move_vertex(Mesh& mesh, const WallTree& wall, Vertex v) {
  const Vec3 normal = normal_at(mesh, v), u = normal.unitOrthogonal(), w = normal.cross(u);
  Star star;
  double step = 0;
  for (Halfedge h : mesh.halfedges_around_target(mesh.halfedge(v))) {
    star.faces.push_back(mesh.face(h));
    star.normals.push_back(area_vector(mesh, mesh.face(h)).normalized());
    step += (vec(mesh.point(mesh.source(h))) - vec(mesh.point(v))).norm() / static_cast<double>(mesh.degree(v));
  }
  double best = smallest_star_angle(mesh, star, 0);
  step *= first_step;
  bool moved = false;
  for (int k = 0; k < step_halvings; step /= 2, ++k)
    for (int d = 0; d < step_directions; ++d) {
      const double heading = 2 * pi * d / step_directions;
      const Point before = mesh.point(v);
      const double aim = best + least_move;
      mesh.point(v) = point(vec(before) + step * (std::cos(heading) * u + std::sin(heading) * w));
      if (smallest_star_angle(mesh, star, aim) >
          aim) { // only a promising step is worth the search for the wall's nearest point
        mesh.point(v) = wall.nearest(mesh.point(v));
        if (const double angle = smallest_star_angle(mesh, star, aim); angle > aim) {
          best = angle;
          moved = true;
          continue;
        }
      }
      mesh.point(v) = before;
    }
  return moved;
}

// A change of the mesh; it returns false, and changes nothing, if it is impossible.
using Change = std::function<bool(Mesh&)>;

Change flip(Edge e) {
  return [e](Mesh& mesh) {
    const Halfedge h = mesh.halfedge(e);
    const Vertex a = mesh.target(mesh.next(h)), b = mesh.target(mesh.next(mesh.opposite(h)));
    if (a == b || mesh.halfedge(a, b) != Mesh::null_halfedge())
      return false;
    CGAL::Euler::flip_edge(h, mesh);
    return true;
  };
}

Change collapse(Edge e, const WallTree& wall) {
  return [e, &wall](Mesh& mesh) {
    const Vertex a = mesh.vertex(e, 0), b = mesh.vertex(e, 1);
    if (!may_move(mesh, a) || !may_move(mesh, b) || !CGAL::Euler::does_satisfy_link_condition(e, mesh))
      return false;
    const Point middle = wall.nearest(CGAL::midpoint(mesh.point(a), mesh.point(b)));
    mesh.point(CGAL::Euler::collapse_edge(e, mesh)) = middle;
    return true;
  };
}

Change split(Edge e, const WallTree& wall) {
  return [e, &wall](Mesh& mesh) {
    const Halfedge h = mesh.halfedge(e);
    const Point middle = wall.nearest(CGAL::midpoint(mesh.point(mesh.source(h)), mesh.point(mesh.target(h))));
    const Halfedge first = CGAL::Euler::split_edge(h, mesh);
    mesh.point(mesh.target(first)) = middle;
    RegionMap region = region_map(mesh);
    for (Halfedge side : {first, mesh.opposite(mesh.next(first))}) {
      const Halfedge half = CGAL::Euler::split_face(side, mesh.next(mesh.next(side)), mesh);
      region[mesh.face(half)] = region[mesh.face(mesh.opposite(half))] = 0; // rims are never split
    }
    return true;
  };
}

// Widens angles of `mesh` as widen_angles() says.
struct AngleOptimiser {
  Mesh mesh;
  const Mesh& surface;
  const WallTree& wall;
  double wanted; // degrees
  bool careful;
  std::set<Face> hopeless; // narrow triangles that no change has improved in this pass

  // The vertices of a triangle and of two rings round it.
  std::set<Vertex> vertices_around(Face f) const {
    std::set<Vertex> patch;
    for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
      patch.insert(v);
    for (int ring = 0; ring < moving_rings; ++ring)
      for (Vertex v : std::vector<Vertex>(patch.begin(), patch.end()))
        for (Vertex w : mesh.vertices_around_target(mesh.halfedge(v)))
          patch.insert(w);
    return patch;
  }

  // Smallest angle (degrees) of the triangles at these vertices that touch no cap.
  static double smallest_patch_angle(const Mesh& in, const std::set<Vertex>& patch) {
    double angle = 180;
    for (Vertex v : patch)
      if (!in.is_removed(v))
        for (Face f : in.faces_around_target(in.halfedge(v)))
          if (!touches_cap(in, f))
            angle = std::min(angle, smallest_angle(in, f));
    return angle;
  }

  // Moves the vertices of a patch one after the other, until none moves any more or `most_sweeps` is reached.
  void relax(Mesh& in, const std::set<Vertex>& patch) const {
    bool moved = true;
    for (int sweep = 0; sweep < most_sweeps && moved; ++sweep) {
      moved = false;
      for (Vertex v : patch)
        if (!in.is_removed(v) && may_move(in, v))
          moved |= move_vertex(in, wall, v);
    }
  }

  // The changes to try at a triangle, before relax(): none, or a flip, collapse or split of one edge at its vertices.
  std::vector<Change> changes(Face f) const {
    std::vector<Change> all{[](Mesh&) { return true; }}; // no change: relax() alone
    std::set<Edge> edges;
    for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
      for (Halfedge h : mesh.halfedges_around_target(mesh.halfedge(v)))
        if (!touches_cap(mesh, mesh.face(h)) && !touches_cap(mesh, mesh.face(mesh.opposite(h))))
          edges.insert(mesh.edge(h));
    for (Edge e : edges)
      all.push_back(flip(e));
    for (Edge e : edges)
      all.push_back(collapse(e, wall));
    for (Edge e : edges)
      all.push_back(split(e, wall));
    return all;
  }

  // Keeps the change that widens the smallest angle round the triangle most. Returns whether there was one.
  bool widen(Face f) {
    const std::set<Vertex> patch = vertices_around(f);
    const double before = smallest_patch_angle(mesh, patch);
    double best_angle = before + least_gain;
    Mesh best;
    for (const Change& change : changes(f)) {
      Mesh trial = mesh;
      std::set<Vertex> moving = patch;
      const std::size_t count = trial.num_vertices();
      if (!change(trial))
        continue;
      for (std::size_t k = count; k < trial.num_vertices(); ++k)
        moving.insert(Vertex(static_cast<Mesh::size_type>(k)));
      relax(trial, moving);
      const double angle = smallest_patch_angle(trial, moving);
      if (angle > best_angle && folded(trial, moving) <= folded(mesh, patch) &&
          creases(trial, moving) <= creases(mesh, patch) && !(careful && crosses(trial, moving))) {
        best_angle = angle;
        best = std::move(trial);
        if (angle >= wanted)
          break;
      }
    }
    if (best.is_empty()) {
      hopeless.insert(f);
      return false;
    }
    mesh = std::move(best);
    return true;
  }

  // Number of triangles at these vertices that stand steeply on the smooth wall. A sharp carina always has some; a
  // change must not add any.
  std::size_t folded(const Mesh& in, const std::set<Vertex>& patch) const {
    std::set<Face> faces;
    for (Vertex v : patch)
      if (!in.is_removed(v) && may_move(in, v))
        for (Face f : in.faces_around_target(in.halfedge(v)))
          faces.insert(f);
    return static_cast<std::size_t>(std::count_if(faces.begin(), faces.end(), [&](Face f) {
      Vec3 centre = Vec3::Zero();
      for (Vertex v : in.vertices_around_face(in.halfedge(f)))
        centre += vec(in.point(v)) / 3;
      return area_vector(in, f).normalized().dot(area_vector(surface, wall.nearest_face(point(centre))).normalized()) <
             cos_folded;
    }));
  }

  // Number of edges at these vertices whose two triangles are folded onto each other. Such triangles need not cross.
  static std::size_t creases(const Mesh& in, const std::set<Vertex>& patch) {
    std::set<Edge> edges;
    for (Vertex v : patch)
      if (!in.is_removed(v))
        for (Face f : in.faces_around_target(in.halfedge(v)))
          for (Halfedge h : in.halfedges_around_face(in.halfedge(f)))
            edges.insert(in.edge(h));
    return static_cast<std::size_t>(std::count_if(edges.begin(), edges.end(), [&](Edge e) {
      const Vec3 a = area_vector(in, in.face(in.halfedge(e))),
                 b = area_vector(in, in.face(in.opposite(in.halfedge(e))));
      return a.dot(b) < cos_crease * a.norm() * b.norm();
    }));
  }

  // Whether triangles at these vertices, or at the vertices next to them, cross each other.
  static bool crosses(const Mesh& in, const std::set<Vertex>& patch) {
    std::set<Face> faces;
    for (Vertex v : patch)
      if (!in.is_removed(v))
        for (Vertex w : in.vertices_around_target(in.halfedge(v)))
          for (Face f : in.faces_around_target(in.halfedge(w)))
            faces.insert(f);
    return crosses_itself(in, {faces.begin(), faces.end()});
  }

  // Smallest angle (degrees) of all triangles that touch no cap.
  double smallest_of_all() const {
    double angle = 180;
    for (Face f : mesh.faces())
      if (!touches_cap(mesh, f))
        angle = std::min(angle, smallest_angle(mesh, f));
    return angle;
  }

  // The triangle with the smallest angle, and this angle (degrees). Triangles at a cap are left out, and those that
  // no change has improved in this pass (`hopeless`).
  std::pair<double, Face> narrowest_triangle() const {
    std::pair<double, Face> found{180, Face()};
    for (Face f : mesh.faces())
      if (const double angle = smallest_angle(mesh, f);
          angle < found.first && !touches_cap(mesh, f) && !hopeless.contains(f))
        found = {angle, f};
    return found;
  }
};

} // namespace

void widen_angles(Mesh& mesh, const Mesh& surface, const WallTree& wall, double wanted, int passes, bool careful) {
  AngleOptimiser optimiser{mesh, surface, wall, wanted, careful, {}};
  optimiser.mesh.set_recycle_garbage(false); // so that no new face takes the index of a removed one
  // an angle that could not be widened at first may give way once its neighbours have changed
  bool changed = true;
  for (int pass = 0; pass < passes && changed && (pass == 0 || optimiser.smallest_of_all() < wanted - pass_tolerance);
       ++pass) {
    optimiser.hopeless.clear();
    changed = false;
    for (std::size_t k = 0; k < most_changes; ++k) {
      const auto [angle, face] = optimiser.narrowest_triangle();
      if (angle >= wanted)
        break;
      changed |= optimiser.widen(face);
    }
  }
  mesh = std::move(optimiser.mesh);
  mesh.collect_garbage();
}

} // namespace anatomy
