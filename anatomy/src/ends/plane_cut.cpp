#include "ends/plane_cut.hpp"
#include "common/error.hpp"
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <algorithm>

namespace anatomy {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using common::InputError;

// Faces made by a cut take the tag of the face they come from.
struct KeepTags : PMP::Corefinement::Default_visitor<Mesh> {
  RegionMap region;
  Mesh* mesh = nullptr;
  int tag = 0;
  void before_subface_creations(Face f, Mesh& m) {
    if (&m == mesh)
      tag = region[f];
  }
  void after_subface_created(Face f, Mesh& m) {
    if (&m == mesh)
      region[f] = tag;
  }
};

// Faces reached from `from` without crossing a marked edge.
template <class Marked> std::vector<Face> side_of(const Mesh& mesh, const Marked& marked, Face from) {
  std::vector<bool> seen(mesh.num_faces(), false);
  std::vector<Face> faces{from};
  seen[from] = true;
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (Halfedge h : mesh.halfedges_around_face(mesh.halfedge(faces[i]))) {
      const Face g = mesh.face(mesh.opposite(h));
      if (g != Mesh::null_face() && !marked[mesh.edge(h)] && !seen[g]) {
        seen[g] = true;
        faces.push_back(g);
      }
    }
  return faces;
}

} // namespace

double cut(Mesh& mesh, const Plane& plane, Vertex tip, const std::string& remedy) {
  Mesh square;
  const Vec3 u = half_width * plane.radius * plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
  std::array<Vertex, 4> corner;
  for (int k = 0; k < 4; ++k)
    corner[static_cast<std::size_t>(k)] =
        square.add_vertex(point(plane.centre + (k == 0 || k == 3 ? -u : u) + (k < 2 ? -v : v)));
  square.add_face(corner[0], corner[1], corner[2]);
  square.add_face(corner[0], corner[2], corner[3]);
  auto marked = mesh.add_property_map<Edge, bool>("e:cut", false).first;
  KeepTags visitor;
  visitor.region = region_map(mesh);
  visitor.mesh = &mesh;
  PMP::corefine(mesh, square, CGAL::parameters::edge_is_constrained_map(marked).visitor(visitor));
  // the cut's own loop is the one nearest to the axis
  Edge nearest;
  double least = 1e300;
  for (Edge e : mesh.edges())
    if (const double d = (vec(mesh.point(mesh.vertex(e, 0))) - plane.centre).norm(); marked[e] && d < least) {
      least = d;
      nearest = e;
    }
  const auto refuse = [&] {
    throw InputError("a plane across the vessel does not separate its end", place(plane.centre),
                     "radius " + std::to_string(plane.radius) + " mm", remedy);
  };
  if (least > 1e299)
    refuse();
  std::vector<Face> drop = side_of(mesh, marked, mesh.face(mesh.halfedge(nearest)));
  std::vector<Face> other = side_of(mesh, marked, mesh.face(mesh.opposite(mesh.halfedge(nearest))));
  const auto holds = [&](const std::vector<Face>& faces) {
    return std::any_of(faces.begin(), faces.end(), [&](Face f) {
      const auto corners = mesh.vertices_around_face(mesh.halfedge(f));
      return std::find(corners.begin(), corners.end(), tip) != corners.end();
    });
  };
  if (tip == Mesh::null_vertex() ? PMP::area(other, mesh) < PMP::area(drop, mesh) : holds(other))
    std::swap(drop, other);
  if (tip != Mesh::null_vertex() && (!holds(drop) || holds(other)))
    refuse();
  const double lost = PMP::area(drop, mesh);
  if (lost > 0.5 * PMP::area(mesh)) // both sides hang together somewhere else
    refuse();
  for (Face f : drop)
    CGAL::Euler::remove_face(mesh.halfedge(f), mesh);
  PMP::keep_largest_connected_components(mesh, 1); // bumps of a rough wall that the plane cuts off stand alone now
  mesh.remove_property_map(marked);
  return lost;
}

void report_cut(std::vector<Repair>& repairs, const std::string& what, const Plane& plane, double lost) {
  char detail[160];
  std::snprintf(detail, sizeof detail, "radius %.3f mm at %s, %.2f mm2 of wall dropped", plane.radius,
                place(plane.centre).c_str(), lost);
  repairs.push_back({what, 1, detail});
}

} // namespace anatomy
