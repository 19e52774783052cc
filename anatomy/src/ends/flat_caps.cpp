#include "ends/flat_caps.hpp"
#include <CGAL/Polygon_mesh_processing/compute_normal.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/convex_hull_2.h>
#include <algorithm>
#include <deque>
#include <set>

namespace anatomy {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;

constexpr double cos_patch = 0.978;      // 12 degrees between a cap's faces and its plane
constexpr double cos_wall = 0.8;         // 37 degrees: faces beside a cap that are nearer to its plane are no wall ...
constexpr double largest_no_wall = 0.25; // ... and may be this part of the area beside it, for chamfers and noise
constexpr double smallest_roundness = 0.6; // 4 pi A / P^2
constexpr double off_plane = 0.03;         // of the patch's equivalent diameter
constexpr double smallest_radius = 0.25;   // of the lumen's mean radius
constexpr double sliver = 0.02;            // of the mean area: too small a triangle to have a normal worth asking
constexpr int fewest_corners = 5;          // of a rim: a facet or two of a coarse wall are no end
constexpr int rings_of_wall = 3;           // beside the rim, so that a chamfer of one triangle does not decide

struct Shape {
  std::vector<Vec3> normal;
  std::vector<double> area;
  double mean_area = 0;
};

Shape shape_of(const Mesh& mesh) {
  Shape shape{std::vector<Vec3>(mesh.number_of_faces()), std::vector<double>(mesh.number_of_faces()), 0};
  for (Face f : mesh.faces()) {
    const Vector n = PMP::compute_face_normal(f, mesh);
    shape.normal[f] = Vec3(n.x(), n.y(), n.z());
    shape.area[f] = PMP::face_area(f, mesh);
    shape.mean_area += shape.area[f] / static_cast<double>(mesh.number_of_faces());
  }
  return shape;
}

// Faces reached from `seed` through faces within 12 degrees of `normal`, or too small to have one but in its plane.
std::vector<Face> grown(const Mesh& mesh, const Shape& shape, Face seed, const Vec3& normal, std::vector<bool>& taken) {
  std::vector<Face> patch;
  std::deque<Face> front{seed};
  taken[seed] = true;
  const Vec3 origin = vec(mesh.point(mesh.target(mesh.halfedge(seed))));
  const double near_plane = 0.1 * std::sqrt(shape.mean_area);
  const auto belongs = [&](Face g) {
    if (shape.area[g] > sliver * shape.mean_area)
      return shape.normal[g].dot(normal) > cos_patch;
    for (Vertex v : mesh.vertices_around_face(mesh.halfedge(g)))
      if (std::abs((vec(mesh.point(v)) - origin).dot(normal)) > near_plane)
        return false;
    return true;
  };
  while (!front.empty()) {
    const Face f = front.front();
    front.pop_front();
    patch.push_back(f);
    for (Face g : mesh.faces_around_face(mesh.halfedge(f)))
      if (!taken[g] && belongs(g)) {
        taken[g] = true;
        front.push_back(g);
      }
  }
  return patch;
}

// Part of the area up to three rings outside the patch that lies nearer to its plane than a wall would.
double no_wall(const Mesh& mesh, const Shape& shape, const std::vector<Face>& patch, const Vec3& cap) {
  std::set<Face> seen(patch.begin(), patch.end());
  std::vector<Face> front = patch;
  double sum = 0, area = 0;
  for (int ring = 0; ring < rings_of_wall; ++ring) {
    std::vector<Face> next;
    for (Face f : front)
      for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
        for (Face g : mesh.faces_around_target(mesh.halfedge(v)))
          if (seen.insert(g).second) {
            next.push_back(g);
            sum += std::abs(shape.normal[g].dot(cap)) > cos_wall ? shape.area[g] : 0;
            area += shape.area[g];
          }
    front = next;
  }
  return area > 0 ? sum / area : 1;
}

Vec3 area_vector(const Shape& shape, const std::vector<Face>& patch) {
  Vec3 total = Vec3::Zero();
  for (Face f : patch)
    total += shape.area[f] * shape.normal[f];
  return total;
}

// Length of the convex hull's outline of the patch seen along its normal.
double hull_perimeter(const Mesh& mesh, const std::vector<Face>& patch, const Vec3& normal) {
  using Planar = Kernel::Point_2;
  const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
  std::vector<Planar> points, hull;
  for (Face f : patch)
    for (Vertex corner : mesh.vertices_around_face(mesh.halfedge(f)))
      points.emplace_back(u.dot(vec(mesh.point(corner))), v.dot(vec(mesh.point(corner))));
  CGAL::convex_hull_2(points.begin(), points.end(), std::back_inserter(hull));
  double perimeter = 0;
  for (std::size_t i = 0; i < hull.size(); ++i)
    perimeter += std::sqrt(CGAL::squared_distance(hull[i], hull[(i + 1) % hull.size()]));
  return perimeter;
}

// Whether the patch is plane, round (by the outline of its faces or of its hull) and has a sharp rim.
bool is_cap(const Mesh& mesh, const Shape& shape, const std::vector<Face>& patch, double smallest_area, bool by_hull) {
  const std::set<Face> inside(patch.begin(), patch.end());
  double perimeter = 0;
  int corners = 0;
  for (Face f : patch)
    for (Halfedge h : mesh.halfedges_around_face(mesh.halfedge(f)))
      if (!inside.contains(mesh.face(mesh.opposite(h)))) {
        perimeter += (vec(mesh.point(mesh.source(h))) - vec(mesh.point(mesh.target(h)))).norm();
        ++corners;
      }
  const Vec3 total = area_vector(shape, patch);
  const double area = total.norm();
  if (corners < fewest_corners || area < smallest_area)
    return false;
  const Vec3 normal = total / area;
  if (by_hull)
    perimeter = hull_perimeter(mesh, patch, normal);
  if (4 * M_PI * area < smallest_roundness * perimeter * perimeter)
    return false;
  double lowest = 1e300, highest = -1e300;
  for (Face f : patch)
    for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f))) {
      const double height = normal.dot(vec(mesh.point(v)));
      lowest = std::min(lowest, height);
      highest = std::max(highest, height);
    }
  return highest - lowest < off_plane * 2 * std::sqrt(area / M_PI) &&
         no_wall(mesh, shape, patch, normal) < largest_no_wall;
}

} // namespace

void tag_flat_caps(Mesh& mesh, double least_radius) {
  mesh.collect_garbage(); // faces count on from zero
  RegionMap region = region_map(mesh);
  const Shape shape = shape_of(mesh);
  std::vector<bool> taken(mesh.number_of_faces(), false);
  int next = 0;
  for (Face f : mesh.faces()) {
    next = std::max(next, region[f]);
    taken[f] = region[f] != 0;
  }
  // a lumen's mean radius bounds the size of its ends from below: bumps of a few triangles are not ends
  const double radius = std::max(least_radius, smallest_radius * 2 * std::abs(PMP::volume(mesh)) / PMP::area(mesh));
  const double smallest_area = M_PI * radius * radius;
  const auto tag = [&](const std::vector<Face>& patch) {
    ++next;
    for (Face f : patch)
      region[f] = next;
  };
  std::vector<std::pair<Face, Vec3>> undecided;
  for (Face seed : mesh.faces()) {
    if (taken[seed] || shape.area[seed] < sliver * shape.mean_area)
      continue;
    const std::vector<Face> patch = grown(mesh, shape, seed, shape.normal[seed], taken);
    const Vec3 total = area_vector(shape, patch);
    if (is_cap(mesh, shape, patch, smallest_area, false))
      tag(patch);
    else if (total.norm() > smallest_area)
      undecided.emplace_back(seed, total.normalized());
  }
  // what contouring chamfers has a zigzag for a rim, and seeds on it that lie out of the cap's plane
  for (const auto& [seed, normal] : undecided) {
    for (Face f : mesh.faces())
      taken[f] = region[f] != 0;
    if (taken[seed])
      continue;
    const std::vector<Face> patch = grown(mesh, shape, seed, normal, taken);
    if (is_cap(mesh, shape, patch, smallest_area, true))
      tag(patch);
  }
}

} // namespace anatomy
