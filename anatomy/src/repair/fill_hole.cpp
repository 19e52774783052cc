#include "repair/fill_hole.hpp"
#include <CGAL/Polygon_mesh_processing/refine.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/boost/graph/Euler_operations.h>
#include <algorithm>

namespace anatomy {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;

// A hole with more edges than this is filled in parts. CGAL's search takes n^3 steps for n edges: 0.2 s for 250.
constexpr std::size_t most_hole_edges = 250;

using Ring = std::vector<Vertex>;

// Finds CGAL's best filling of a ring of vertices and appends its triangles. They are ordered so that a mesh can take
// them one by one: at least two sides of each belong to the ring or to an earlier triangle. Returns whether they fill
// the whole ring.
bool add_filling(const Mesh& mesh, const Ring& ring, std::vector<std::array<Vertex, 3>>& triangles) {
  if (ring.size() < 3)
    return true;
  std::vector<Point> points;
  for (Vertex v : ring)
    points.push_back(mesh.point(v));
  std::vector<CGAL::Triple<int, int, int>> found;
  PMP::triangulate_hole_polyline(points, std::back_inserter(found));
  for (std::size_t i = found.size(); i-- > 0;) {
    std::array<std::size_t, 3> corner{static_cast<std::size_t>(found[i].first),
                                      static_cast<std::size_t>(found[i].second),
                                      static_cast<std::size_t>(found[i].third)};
    std::sort(corner.begin(), corner.end());
    triangles.push_back({ring[corner[0]], ring[corner[1]], ring[corner[2]]});
  }
  return found.size() == ring.size() - 2;
}

// Fills a large ring in parts. A chord over every few edges cuts off a small ring. Each small ring is filled, and then
// the ring of the chords. Returns no faces, and leaves the mesh unchanged, if this fails.
std::vector<Face> fill_in_parts(Mesh& mesh, const Ring& ring) {
  const std::size_t step = (ring.size() + most_hole_edges - 1) / most_hole_edges;
  std::vector<std::array<Vertex, 3>> triangles;
  Ring chords;
  bool whole = true;
  for (std::size_t i = 0; i < ring.size(); i += step) {
    chords.push_back(ring[i]);
    Ring part;
    for (std::size_t k = i; k <= std::min(i + step, ring.size()); ++k)
      part.push_back(ring[k % ring.size()]);
    whole = whole && add_filling(mesh, part, triangles);
  }
  if (!whole || !add_filling(mesh, chords, triangles))
    return {};
  std::vector<Face> faces;
  for (const auto& [a, b, c] : triangles)
    if (const Face f = mesh.add_face(a, b, c); f != Mesh::null_face()) {
      faces.push_back(f);
    } else { // CGAL refuses the triangle, since the wall already has one of its edges
      for (Face g : faces)
        CGAL::Euler::remove_face(mesh.halfedge(g), mesh);
      return {};
    }
  return faces;
}

// The ring's points that lie on the edge of h within `tolerance` (mm), in order from the edge's source to its target.
std::vector<Point> points_on(const Mesh& mesh, const Ring& ring, Halfedge h, double tolerance) {
  const Vec3 a = vec(mesh.point(mesh.source(h))), along = vec(mesh.point(mesh.target(h))) - a;
  std::vector<std::pair<double, Point>> found;
  for (Vertex v : ring) {
    const Vec3 p = vec(mesh.point(v)) - a;
    const double length = along.norm(), t = p.dot(along) / (length * length);
    if (v != mesh.source(h) && v != mesh.target(h) && t * length > tolerance && (1 - t) * length > tolerance &&
        (p - t * along).norm() < tolerance)
      found.emplace_back(t, mesh.point(v));
  }
  std::sort(found.begin(), found.end());
  std::vector<Point> points;
  for (const auto& [t, p] : found)
    if (points.empty() || points.back() != p)
      points.push_back(p);
  return points;
}

} // namespace

std::vector<Face> fill_hole(Mesh& mesh, Halfedge border) {
  Ring ring;
  for (Halfedge h : CGAL::halfedges_around_face(border, mesh))
    ring.push_back(mesh.target(h));
  std::vector<Face> faces;
  if (ring.size() > most_hole_edges)
    faces = fill_in_parts(mesh, ring);
  if (faces.empty())
    PMP::triangulate_hole(mesh, border, std::back_inserter(faces));
  return faces;
}

std::size_t divide_border(Mesh& mesh, Halfedge border, double tolerance) {
  Ring ring;
  std::vector<Halfedge> edges;
  for (Halfedge h : CGAL::halfedges_around_face(border, mesh)) {
    ring.push_back(mesh.target(h));
    edges.push_back(h);
  }
  if (ring.size() > most_hole_edges)
    return 0;
  std::size_t count = 0;
  for (Halfedge h : edges)
    for (const Point& p : points_on(mesh, ring, h, tolerance)) {
      const Halfedge before = CGAL::Euler::split_edge(h, mesh); // h now starts at the new vertex
      mesh.point(mesh.target(before)) = p;
      const Halfedge inside = mesh.opposite(h); // its face is a quadrangle now
      CGAL::Euler::split_face(inside, mesh.next(mesh.next(inside)), mesh);
      ++count;
    }
  return count;
}

std::vector<Face> cap_loop(Mesh& mesh, const Loop& loop) {
  // CGAL estimates the loop's normal as a sum of triangle normals, each turned towards positive x. If they are nearly
  // perpendicular to x, noise decides how each is turned. So the loop is rotated first, to a normal along (1, 1, 1).
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(loop.normal, Vec3::Ones());
  auto turned = mesh.add_property_map<Vertex, Point>("v:turned").first;
  for (Vertex v : mesh.vertices())
    turned[v] = point(turn * vec(mesh.point(v)));
  std::vector<Face> faces;
  PMP::triangulate_hole(mesh, loop.halfedge, std::back_inserter(faces),
                        CGAL::parameters::vertex_point_map(turned).use_2d_constrained_delaunay_triangulation(true));
  mesh.remove_property_map(turned);
  std::vector<Vertex> vertices;
  PMP::refine(mesh, std::vector<Face>(faces), std::back_inserter(faces), std::back_inserter(vertices));
  return faces;
}

} // namespace anatomy
