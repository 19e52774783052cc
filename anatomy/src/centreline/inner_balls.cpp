#include "centreline/inner_balls.hpp"
#include "common/error.hpp"
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Polygon_mesh_processing/compute_normal.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <algorithm>

namespace anatomy {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<std::size_t, Kernel>;
using CellBase = CGAL::Triangulation_cell_base_with_info_3<int, Kernel>;
using Delaunay = CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;

constexpr double beside_end = 1.1; // radii: what is farther from an end's axis belongs to a vessel that runs past it

bool beyond_an_end(const Vec3& p, const std::vector<End>& ends) {
  return std::any_of(ends.begin(), ends.end(), [&](const End& end) {
    const Vec3 d = p - end.centre;
    const double outside = d.dot(end.normal), aside = (d - outside * end.normal).norm();
    return outside > 0 && d.norm() < 3 * end.radius() && aside < beside_end * end.radius();
  });
}

// Whether the way from a to b leads through a cap: in a bend the ends may face each other.
bool crosses_an_end(const Vec3& a, const Vec3& b, const std::vector<End>& ends) {
  return std::any_of(ends.begin(), ends.end(), [&](const End& end) {
    const double ha = (a - end.centre).dot(end.normal), hb = (b - end.centre).dot(end.normal);
    return (ha > 0) != (hb > 0) && (a + ha / (ha - hb) * (b - a) - end.centre).norm() < beside_end * end.radius();
  });
}

// Vertices of the wall with their outward normals (of wall faces only, so that a rim's is radial).
void wall_points(const Mesh& mesh, std::vector<std::pair<Point, std::size_t>>& points, std::vector<Vec3>& normals) {
  const RegionMap region = region_map(mesh);
  for (Vertex v : mesh.vertices()) {
    Vec3 normal = Vec3::Zero();
    for (Face f : mesh.faces_around_target(mesh.halfedge(v)))
      if (f != Mesh::null_face() && region[f] == 0) {
        const Vector n = PMP::compute_face_normal(f, mesh);
        normal += PMP::face_area(f, mesh) * Vec3(n.x(), n.y(), n.z());
      }
    if (normal.norm() == 0)
      continue;
    points.emplace_back(mesh.point(v), normals.size());
    normals.push_back(normal.normalized());
  }
}

} // namespace

Balls inner_balls(const Mesh& mesh, const std::vector<End>& ends) {
  std::vector<std::pair<Point, std::size_t>> points;
  std::vector<Vec3> normals;
  wall_points(mesh, points, normals);
  Delaunay delaunay(points.begin(), points.end());
  Balls balls;
  for (auto cell : delaunay.finite_cell_handles()) {
    cell->info() = -1;
    const Vec3 c = vec(CGAL::circumcenter(delaunay.tetrahedron(cell)));
    bool inside = c.allFinite();
    for (int k = 0; k < 4 && inside; ++k) {
      const Vec3 p = vec(cell->vertex(k)->point());
      inside = (c - p).dot(normals[cell->vertex(k)->info()]) < 0;
    }
    if (!inside || beyond_an_end(c, ends))
      continue;
    cell->info() = static_cast<int>(balls.centre.size());
    balls.centre.push_back(c);
    balls.radius.push_back((c - vec(cell->vertex(0)->point())).norm());
  }
  balls.neighbours.resize(balls.centre.size());
  for (auto cell : delaunay.finite_cell_handles())
    if (cell->info() >= 0)
      for (int k = 0; k < 4; ++k) {
        const auto other = cell->neighbor(k);
        if (delaunay.is_infinite(other) || other->info() < 0)
          continue;
        const auto i = static_cast<std::size_t>(cell->info()), j = static_cast<std::size_t>(other->info());
        if (!crosses_an_end(balls.centre[i], balls.centre[j], ends))
          balls.neighbours[i].push_back(j);
      }
  return balls;
}

std::size_t ball_at(const Balls& balls, const End& end) {
  std::size_t best = balls.centre.size();
  double nearest = 2 * end.radius();
  for (std::size_t i = 0; i < balls.centre.size(); ++i) {
    const double d = (balls.centre[i] - end.centre).norm();
    if (balls.radius[i] > 0.5 * end.radius() && d < nearest) {
      nearest = d;
      best = i;
    }
  }
  if (best == balls.centre.size())
    throw common::ComputationError("no axis found at an end", place(end.centre),
                                   "no inscribed ball there; radius of the end " + std::to_string(end.radius()) + " mm",
                                   "if a vessel ends there, give a finer surface; if it is a hole or a scrap of a rim, "
                                   "fill it or smooth the surface");
  return best;
}

Ways cheapest_ways(const Balls& balls, std::size_t from) {
  std::vector<WayGraph::Link> links;
  std::vector<double> costs;
  for (std::size_t i = 0; i < balls.centre.size(); ++i)
    for (std::size_t j : balls.neighbours[i]) {
      links.emplace_back(i, j);
      costs.push_back((balls.centre[i] - balls.centre[j]).norm() * 2 / (balls.radius[i] + balls.radius[j]));
    }
  return WayGraph(balls.centre.size(), links, costs).from(from);
}

} // namespace anatomy
