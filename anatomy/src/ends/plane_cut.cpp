#include "ends/plane_cut.hpp"
#include "common/error.hpp"
#include "core/measures.hpp"
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <algorithm>

namespace anatomy {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using common::InputError;

// Gives faces made by a cut the tag of the face they come from.
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

// The faces that can be reached from the face `from` without crossing a marked edge.
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

[[noreturn]] void refuse(const Plane& plane, const std::string& remedy) {
  throw InputError("a plane across the vessel does not separate its end", point_text(plane.centre),
                   "radius " + std::to_string(plane.radius) + " mm", remedy);
}

// Cuts the mesh by the square of the plane, which marks loops of edges. Returns the faces on either side of the loop
// nearest to the plane's centre.
std::pair<std::vector<Face>, std::vector<Face>> cut_into_sides(Mesh& mesh, const Plane& plane,
                                                               const std::string& remedy) {
  Mesh square;
  const Vec3 u = square_half_width * plane.radius * plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
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
  // Other loops are cuts through neighbouring vessels.
  Edge nearest;
  double least = 1e300;
  for (Edge e : mesh.edges())
    if (const double d = (vec(mesh.point(mesh.vertex(e, 0))) - plane.centre).norm(); marked[e] && d < least) {
      least = d;
      nearest = e;
    }
  if (least > 1e299)
    refuse(plane, remedy);
  auto both = std::make_pair(side_of(mesh, marked, mesh.face(mesh.halfedge(nearest))),
                             side_of(mesh, marked, mesh.face(mesh.opposite(mesh.halfedge(nearest)))));
  mesh.remove_property_map(marked);
  return both;
}

bool contains_vertex(const Mesh& mesh, const std::vector<Face>& faces, Vertex vertex) {
  return std::any_of(faces.begin(), faces.end(), [&](Face f) {
    const auto corners = mesh.vertices_around_face(mesh.halfedge(f));
    return std::find(corners.begin(), corners.end(), vertex) != corners.end();
  });
}

// Removes the faces and returns their area (mm2).
double remove_faces(Mesh& mesh, const std::vector<Face>& faces) {
  const double lost = surface_area(mesh, faces);
  for (Face f : faces)
    CGAL::Euler::remove_face(mesh.halfedge(f), mesh);
  return lost;
}

} // namespace

double cut_at_plane(Mesh& mesh, const Plane& plane, Vertex tip, const std::string& remedy) {
  auto [drop, other] = cut_into_sides(mesh, plane, remedy);
  if (tip == Mesh::null_vertex() ? surface_area(mesh, other) < surface_area(mesh, drop)
                                 : contains_vertex(mesh, other, tip))
    std::swap(drop, other);
  if (tip != Mesh::null_vertex() && (!contains_vertex(mesh, drop, tip) || contains_vertex(mesh, other, tip)))
    refuse(plane, remedy);
  if (surface_area(mesh, drop) > 0.5 * surface_area(mesh)) // then the two sides are connected elsewhere
    refuse(plane, remedy);
  const double lost = remove_faces(mesh, drop);
  PMP::keep_largest_connected_components(mesh, 1); // drops bumps of a rough wall that the plane has cut off
  return lost;
}

double cut_and_keep(Mesh& mesh, const Plane& plane, Vertex vertex, const std::string& remedy) {
  auto [drop, kept] = cut_into_sides(mesh, plane, remedy);
  if (contains_vertex(mesh, drop, vertex))
    std::swap(drop, kept);
  if (!contains_vertex(mesh, kept, vertex) || contains_vertex(mesh, drop, vertex))
    refuse(plane, remedy);
  std::vector<bool> keep(mesh.num_faces(), false);
  for (Face f : kept)
    keep[f] = true;
  std::vector<Face> rest;
  std::copy_if(mesh.faces().begin(), mesh.faces().end(), std::back_inserter(rest), [&](Face f) { return !keep[f]; });
  return remove_faces(mesh, rest);
}

void report_cut(std::vector<Repair>& repairs, const std::string& what, const Plane& plane, double lost) {
  char detail[160];
  std::snprintf(detail, sizeof detail, "radius %.3f mm at %s, %.2f mm2 of wall dropped", plane.radius,
                point_text(plane.centre).c_str(), lost);
  repairs.push_back({what, 1, detail});
}

} // namespace anatomy
