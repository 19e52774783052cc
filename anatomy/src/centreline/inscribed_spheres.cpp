#include "centreline/inscribed_spheres.hpp"
#include "common/error.hpp"
#include "core/measures.hpp"
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Polygon_mesh_processing/compute_normal.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <algorithm>

namespace anatomy {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<std::size_t, Kernel>;
using CellBase = CGAL::Triangulation_cell_base_with_info_3<int, Kernel>;
using Delaunay = CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;

// Places farther from an end's axis than this (in radii of the end) belong to a vessel that runs past the end.
constexpr double end_margin_radii = 1.1;
// A sphere whose wall points all lie nearer to each other than this (in sphere radii) touches only one patch of the
// wall.
constexpr double one_patch_radii = 0.2;

// Whether p lies beyond a cap, at any distance. A sphere there may touch only the cap's rim, whose normals do not show
// that the sphere is outside.
bool lies_beyond_cap(const Vec3& p, const std::vector<End>& ends) {
  return std::any_of(ends.begin(), ends.end(), [&](const End& end) {
    const Vec3 d = p - end.centre;
    const double outside = d.dot(end.normal), aside = (d - outside * end.normal).norm();
    return outside > 0 && aside < end_margin_radii * end.radius();
  });
}

// Whether the line from a to b passes through a cap. In a bend two ends may face each other.
bool crosses_cap(const Vec3& a, const Vec3& b, const std::vector<End>& ends) {
  return std::any_of(ends.begin(), ends.end(), [&](const End& end) {
    const double ha = (a - end.centre).dot(end.normal), hb = (b - end.centre).dot(end.normal);
    return (ha > 0) != (hb > 0) && (a + ha / (ha - hb) * (b - a) - end.centre).norm() < end_margin_radii * end.radius();
  });
}

// Decides whether the circumcentre c of a cell is in the lumen. Mostly the normals of the cell's four points, which the
// caller has tested, show this. But for four points of a flat patch, such as the rim of a cap, rounding errors may put
// c anywhere. Then the position of c in the mesh decides, which takes longer.
class InsideTest {
public:
  InsideTest(const Mesh& mesh, const std::vector<End>& ends) : mesh_(mesh), ends_(ends), box_(PMP::bbox(mesh)) {}
  bool operator()(const Delaunay::Cell_handle& cell, const Vec3& c, double radius) {
    if (c.x() < box_.xmin() || c.x() > box_.xmax() || c.y() < box_.ymin() || c.y() > box_.ymax() ||
        c.z() < box_.zmin() || c.z() > box_.zmax())
      return false;
    double longest = 0;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < i; ++j)
        longest = std::max(longest, (vec(cell->vertex(i)->point()) - vec(cell->vertex(j)->point())).norm());
    if (longest > one_patch_radii * radius && !lies_beyond_cap(c, ends_))
      return true;
    if (!side_)
      side_ = std::make_unique<CGAL::Side_of_triangle_mesh<Mesh, Kernel>>(mesh_);
    return (*side_)(point(c)) == CGAL::ON_BOUNDED_SIDE;
  }

private:
  const Mesh& mesh_;
  const std::vector<End>& ends_;
  CGAL::Bbox_3 box_;
  std::unique_ptr<CGAL::Side_of_triangle_mesh<Mesh, Kernel>> side_;
};

// Vertices of the wall and their outward normals. Only wall faces count for a normal, so that it is radial at a rim.
void wall_points(const Mesh& mesh, std::size_t every, std::vector<std::pair<Point, std::size_t>>& points,
                 std::vector<Vec3>& normals) {
  const RegionMap region = region_map(mesh);
  for (Vertex v : mesh.vertices()) {
    if (v.idx() % every != 0)
      continue;
    Vec3 normal = Vec3::Zero();
    for (Face f : mesh.faces_around_target(mesh.halfedge(v)))
      if (f != Mesh::null_face() && region[f] == 0) {
        const Vector n = PMP::compute_face_normal(f, mesh);
        normal += face_area(mesh, f) * Vec3(n.x(), n.y(), n.z());
      }
    if (normal.norm() == 0)
      continue;
    points.emplace_back(mesh.point(v), normals.size());
    normals.push_back(normal.normalized());
  }
}

} // namespace

InscribedSpheres inscribed_spheres(const Mesh& mesh, const std::vector<End>& ends, std::size_t every) {
  std::vector<std::pair<Point, std::size_t>> points;
  std::vector<Vec3> normals;
  wall_points(mesh, every, points, normals);
  Delaunay delaunay(points.begin(), points.end());
  InscribedSpheres spheres;
  InsideTest in_lumen(mesh, ends);
  for (auto cell : delaunay.finite_cell_handles()) {
    cell->info() = -1;
    const Vec3 c = vec(CGAL::circumcenter(delaunay.tetrahedron(cell)));
    bool inside = c.allFinite();
    for (int k = 0; k < 4 && inside; ++k) {
      const Vec3 p = vec(cell->vertex(k)->point());
      inside = (c - p).dot(normals[cell->vertex(k)->info()]) < 0;
    }
    if (!inside || !in_lumen(cell, c, (c - vec(cell->vertex(0)->point())).norm()))
      continue;
    cell->info() = static_cast<int>(spheres.centre.size());
    spheres.centre.push_back(c);
    spheres.radius.push_back((c - vec(cell->vertex(0)->point())).norm());
  }
  spheres.neighbours.resize(spheres.centre.size());
  for (auto cell : delaunay.finite_cell_handles())
    if (cell->info() >= 0)
      for (int k = 0; k < 4; ++k) {
        const auto other = cell->neighbor(k);
        if (delaunay.is_infinite(other) || other->info() < 0)
          continue;
        const auto i = static_cast<std::size_t>(cell->info()), j = static_cast<std::size_t>(other->info());
        if (!crosses_cap(spheres.centre[i], spheres.centre[j], ends))
          spheres.neighbours[i].push_back(j);
      }
  return spheres;
}

bool leads_away(const InscribedSpheres& spheres, std::size_t from, const Vec3& p, double reach,
                std::vector<bool>& seen) {
  std::vector<std::size_t> front{from};
  while (!front.empty()) {
    const std::size_t i = front.back();
    front.pop_back();
    if (seen[i])
      continue;
    seen[i] = true;
    if ((spheres.centre[i] - p).norm() > reach)
      return true;
    front.insert(front.end(), spheres.neighbours[i].begin(), spheres.neighbours[i].end());
  }
  return false;
}

std::size_t sphere_at_end(const InscribedSpheres& spheres, const End& end) {
  const auto distance = [&](std::size_t i) { return (spheres.centre[i] - end.centre).norm(); };
  std::vector<std::size_t> filling;
  for (std::size_t i = 0; i < spheres.centre.size(); ++i)
    if (spheres.radius[i] > 0.5 * end.radius() && distance(i) < 2 * end.radius())
      filling.push_back(i);
  std::sort(filling.begin(), filling.end(), [&](std::size_t a, std::size_t b) { return distance(a) < distance(b); });
  // `seen` holds the spheres of failed searches. None of them leads into the vessel, so later searches skip them.
  std::vector<bool> seen(spheres.centre.size(), false);
  for (std::size_t i : filling)
    if (leads_away(spheres, i, end.centre, end.radius(), seen))
      return i;
  throw common::ComputationError(
      "no axis found at an end", point_text(end.centre),
      "no inscribed ball there; radius of the end " + std::to_string(end.radius()) + " mm",
      "if a vessel ends there, export a finer surface; behind a lip or a funnel, cut it by --cut; if it is a hole or a "
      "face of the wall, fill or smooth it, or name the ends by --inlet and --outlet");
}

ShortestPaths cheapest_paths(const InscribedSpheres& spheres, std::size_t from) {
  std::vector<CostGraph::Link> links;
  std::vector<double> costs;
  for (std::size_t i = 0; i < spheres.centre.size(); ++i)
    for (std::size_t j : spheres.neighbours[i]) {
      links.emplace_back(i, j);
      costs.push_back((spheres.centre[i] - spheres.centre[j]).norm() * 2 / (spheres.radius[i] + spheres.radius[j]));
    }
  return CostGraph(spheres.centre.size(), links, costs).from(from);
}

} // namespace anatomy
