#include "voronoi.hpp"
#include "common/error.hpp"
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Polygon_mesh_processing/compute_normal.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <algorithm>
#include <queue>

namespace anatomy {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<std::size_t, Kernel>;
using CellBase = CGAL::Triangulation_cell_base_with_info_3<int, Kernel>;
using Delaunay = CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;

struct Nodes {
  std::vector<Vec3> centre;
  std::vector<double> radius;
  std::vector<std::vector<std::size_t>> neighbours;
};

bool beyond_an_end(const Vec3& p, const std::vector<End>& ends) {
  return std::any_of(ends.begin(), ends.end(), [&](const End& end) {
    const Vec3 d = p - end.centre;
    const double outside = d.dot(end.normal);
    return outside > 0 && d.norm() < 3 * end.radius();
  });
}

// Whether the way from a to b leads through a cap: in a bend the ends may face each other.
bool crosses_an_end(const Vec3& a, const Vec3& b, const std::vector<End>& ends) {
  return std::any_of(ends.begin(), ends.end(), [&](const End& end) {
    const double ha = (a - end.centre).dot(end.normal), hb = (b - end.centre).dot(end.normal);
    return (ha > 0) != (hb > 0) && (a + ha / (ha - hb) * (b - a) - end.centre).norm() < 2 * end.radius();
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

Nodes inner_nodes(const Mesh& mesh, const std::vector<End>& ends) {
  std::vector<std::pair<Point, std::size_t>> points;
  std::vector<Vec3> normals;
  wall_points(mesh, points, normals);
  Delaunay delaunay(points.begin(), points.end());
  Nodes nodes;
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
    cell->info() = static_cast<int>(nodes.centre.size());
    nodes.centre.push_back(c);
    nodes.radius.push_back((c - vec(cell->vertex(0)->point())).norm());
  }
  nodes.neighbours.resize(nodes.centre.size());
  for (auto cell : delaunay.finite_cell_handles())
    if (cell->info() >= 0)
      for (int k = 0; k < 4; ++k) {
        const auto other = cell->neighbor(k);
        if (delaunay.is_infinite(other) || other->info() < 0)
          continue;
        const auto i = static_cast<std::size_t>(cell->info()), j = static_cast<std::size_t>(other->info());
        if (!crosses_an_end(nodes.centre[i], nodes.centre[j], ends))
          nodes.neighbours[i].push_back(j);
      }
  return nodes;
}

// The node nearest to the end's centre among balls that fill at least half of the end.
std::size_t seed_of(const Nodes& nodes, const End& end) {
  std::size_t best = nodes.centre.size();
  double nearest = 2 * end.radius();
  for (std::size_t i = 0; i < nodes.centre.size(); ++i) {
    const double d = (nodes.centre[i] - end.centre).norm();
    if (nodes.radius[i] > 0.5 * end.radius() && d < nearest) {
      nearest = d;
      best = i;
    }
  }
  if (best == nodes.centre.size())
    throw common::ComputationError("no axis found at an end", end.name + " at " + place(end.centre),
                                   "no inscribed ball", "remesh finer: the end has too few vertices round it");
  return best;
}

std::vector<std::size_t> shortest_path_tree(const Nodes& nodes, std::size_t from) {
  constexpr double infinity = 1e300;
  std::vector<double> cost(nodes.centre.size(), infinity);
  std::vector<std::size_t> before(nodes.centre.size(), nodes.centre.size());
  using Item = std::pair<double, std::size_t>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
  cost[from] = 0;
  queue.emplace(0, from);
  while (!queue.empty()) {
    const auto [c, i] = queue.top();
    queue.pop();
    if (c > cost[i])
      continue;
    for (std::size_t j : nodes.neighbours[i]) {
      const double next = c + (nodes.centre[i] - nodes.centre[j]).norm() * 2 / (nodes.radius[i] + nodes.radius[j]);
      if (next < cost[j]) {
        cost[j] = next;
        before[j] = i;
        queue.emplace(next, j);
      }
    }
  }
  return before;
}

} // namespace

std::vector<Path> voronoi_paths(const Mesh& mesh, const std::vector<End>& ends, std::size_t inlet) {
  const Nodes nodes = inner_nodes(mesh, ends);
  const std::size_t from = seed_of(nodes, ends[inlet]);
  const std::vector<std::size_t> before = shortest_path_tree(nodes, from);
  std::vector<Path> paths(ends.size());
  for (std::size_t e = 0; e < ends.size(); ++e) {
    if (e == inlet)
      continue;
    std::size_t at = seed_of(nodes, ends[e]);
    for (; at != from && at != nodes.centre.size(); at = before[at]) {
      paths[e].points.push_back(nodes.centre[at]);
      paths[e].radius.push_back(nodes.radius[at]);
    }
    if (at != from)
      throw common::ComputationError("no way through the lumen from the inlet to an end", place(ends[e].centre),
                                     std::to_string(nodes.centre.size()) + " inscribed balls",
                                     "use a smaller edge: the lumen is too narrow for it somewhere");
    paths[e].points.push_back(nodes.centre[from]);
    paths[e].radius.push_back(nodes.radius[from]);
    std::reverse(paths[e].points.begin(), paths[e].points.end());
    std::reverse(paths[e].radius.begin(), paths[e].radius.end());
  }
  return paths;
}

} // namespace anatomy
