#include "fill_hole.hpp"
#include <CGAL/Polygon_mesh_processing/refine.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>

namespace anatomy {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;

// CGAL's search among the triangles of a 3D Delaunay triangulation meets them in an order that depends on where its
// cells lie in memory, and of equally good fillings (a plane hole has many) keeps the first. The search among all
// triangles does not, but takes n^3 steps: 0.2 s for this many edges.
constexpr std::size_t most_edges = 250;

} // namespace

std::vector<Face> filled(Mesh& mesh, Halfedge border) {
  const std::size_t edges = CGAL::halfedges_around_face(border, mesh).size();
  std::vector<Face> faces;
  PMP::triangulate_hole(mesh, border, std::back_inserter(faces),
                        CGAL::parameters::use_delaunay_triangulation(edges > most_edges));
  return faces;
}

std::vector<Face> capped(Mesh& mesh, const Loop& loop) {
  // CGAL sums the normals of the loop's triangles, turned towards positive x: turned so that none of them is near zero
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(loop.normal, Vec3::Ones());
  auto turned = mesh.add_property_map<Vertex, Point>("v:turned").first;
  for (Vertex v : mesh.vertices())
    turned[v] = point(turn * vec(mesh.point(v)));
  std::vector<Face> faces;
  PMP::triangulate_hole(mesh, loop.halfedge, std::back_inserter(faces),
                        CGAL::parameters::vertex_point_map(turned)
                            .use_2d_constrained_delaunay_triangulation(true)
                            .use_delaunay_triangulation(loop.halfedges > most_edges));
  mesh.remove_property_map(turned);
  std::vector<Vertex> vertices;
  PMP::refine(mesh, std::vector<Face>(faces), std::back_inserter(faces), std::back_inserter(vertices));
  return faces;
}

} // namespace anatomy
