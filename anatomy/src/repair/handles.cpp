#include "repair/handles.hpp"
#include "common/error.hpp"
#include "core/measures.hpp"
#include "repair/fill_hole.hpp"
#include "repair/tips.hpp"
#include <CGAL/boost/graph/Euler_operations.h>
#include <set>

namespace anatomy {
namespace {

constexpr double largest_patch_radii = 0.35;                   // largest radius of a patch, in mean radii of the lumen
constexpr std::array<double, 5> patch_edges{2, 3, 4.5, 7, 10}; // radii of the patches tried, in mean edge lengths
constexpr int most_search_rounds = 5;                          // largest number of rounds of search and removal

double mean_edge(const Mesh& mesh) {
  double sum = 0;
  for (Edge e : mesh.edges())
    sum += (vec(mesh.point(mesh.vertex(e, 0))) - vec(mesh.point(mesh.vertex(e, 1)))).norm();
  return sum / static_cast<double>(mesh.number_of_edges());
}

// The connected patch of faces round vertex v whose corners all lie within `reach` (mm) of v.
std::set<Face> patch_around(const Mesh& mesh, Vertex v, double reach) {
  const Vec3 centre = vec(mesh.point(v));
  std::set<Face> patch;
  std::vector<Face> open;
  const auto add = [&](Face f) {
    for (Vertex w : mesh.vertices_around_face(mesh.halfedge(f)))
      if ((vec(mesh.point(w)) - centre).norm() > reach)
        return;
    if (patch.insert(f).second)
      open.push_back(f);
  };
  for (Face f : mesh.faces_around_target(mesh.halfedge(v)))
    add(f);
  while (!open.empty()) {
    const Face f = open.back();
    open.pop_back();
    for (Halfedge h : mesh.halfedges_around_face(mesh.halfedge(f)))
      add(mesh.face(mesh.opposite(h)));
  }
  return patch;
}

// The halfedges along the patch's rim, on the patch's side.
std::vector<Halfedge> rim_of(const Mesh& mesh, const std::set<Face>& patch) {
  std::vector<Halfedge> rim;
  for (Face f : patch)
    for (Halfedge h : mesh.halfedges_around_face(mesh.halfedge(f)))
      if (!patch.count(mesh.face(mesh.opposite(h))))
        rim.push_back(h);
  return rim;
}

// Whether the rim is one loop that passes each of its vertices once.
bool is_one_loop(const Mesh& mesh, const std::vector<Halfedge>& rim) {
  std::map<Vertex, Vertex> after;
  for (Halfedge h : rim)
    if (!after.emplace(mesh.source(h), mesh.target(h)).second)
      return false;
  if (rim.empty())
    return false;
  std::size_t steps = 0;
  Vertex v = after.begin()->first;
  do {
    v = after.at(v);
    ++steps;
  } while (v != after.begin()->first && steps <= rim.size());
  return steps == rim.size();
}

// Number of handles in a patch with one rim of `rim` edges, by its Euler characteristic.
long genus(const Mesh& mesh, const std::set<Face>& patch, std::size_t rim) {
  std::set<Vertex> vertices;
  for (Face f : patch)
    for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
      vertices.insert(v);
  const long edges = static_cast<long>(3 * patch.size() + rim) / 2;
  return (1 - (static_cast<long>(vertices.size()) - edges + static_cast<long>(patch.size()))) / 2;
}

// Looks round vertex v for the smallest patch that holds a handle, cuts it out and closes its rim. Returns the number
// of handles removed.
// @param edge mean edge of the mesh, mm
// @param largest largest radius of a patch, mm
long close_patch(Mesh& mesh, Vertex v, double edge, double largest) {
  for (double edges : patch_edges) {
    const std::set<Face> patch = patch_around(mesh, v, std::min(edges * edge, largest));
    const std::vector<Halfedge> rim = rim_of(mesh, patch);
    if (!is_one_loop(mesh, rim))
      continue;
    const long handles = genus(mesh, patch, rim.size());
    if (handles < 1)
      continue;
    for (Face f : patch)
      CGAL::Euler::remove_face(mesh.halfedge(f), mesh);
    if (fill_hole(mesh, rim.front()).empty())
      throw common::InputError("a small handle of the surface cannot be closed", point_text(vec(mesh.point(v))),
                               std::to_string(rim.size()) + " edges round it", "smooth the surface there");
    return handles;
  }
  return 0;
}

void compact(Mesh& mesh) {
  remove_isolated_vertices(mesh);
  mesh.collect_garbage();
}

} // namespace

void remove_small_handles(Mesh& mesh, std::vector<Repair>& repairs) {
  compact(mesh);
  const double edge = mean_edge(mesh), largest = largest_patch_radii * mean_radius(mesh);
  long removed = 0;
  Vec3 first = Vec3::Zero();
  for (int round = 0; round < most_search_rounds; ++round) {
    long now = 0;
    for (Vertex v : places_on_handles(mesh)) {
      if (mesh.is_removed(v)) // v was cut out with an earlier patch
        continue;
      const Vec3 here = vec(mesh.point(v));
      const long closed = close_patch(mesh, v, edge, largest);
      if (closed > 0 && removed + now == 0)
        first = here;
      now += closed;
    }
    removed += now;
    compact(mesh);
    if (now == 0)
      break;
  }
  if (removed > 0)
    repairs.push_back({"small handles removed", static_cast<std::size_t>(removed), "first near " + point_text(first)});
}

} // namespace anatomy
