#include "vci/geometry/sections.hpp"
#include "vci/geometry/surface.hpp"

#include <Eigen/Geometry>
#include <map>
#include <utility>

namespace vci {

namespace {

/// A point where the plane meets the smooth surface, near an edge of a triangle.
struct PlaneCrossing {
  Vec3 point, normal; ///< mm; interpolated normal of the surface
};

/// The plane cuts the edge from a to b at the share t of its length. Returns the point of the smooth surface that lies
/// beside this cut in the plane.
/// @param unit_normals unit normals of the vertices
/// @param plane unit normal of the plane
PlaneCrossing crossing_at(int a, int b, double t, const Vectors& points, const Vectors& unit_normals,
                          const Vec3& plane) {
  const Vec3 side = points[b] - points[a], turn = unit_normals[b] - unit_normals[a];
  const Vec3 normal = unit_normals[a] + t * turn;
  const Vec3 outward = (normal - normal.dot(plane) * plane).normalized();
  return {points[a] + t * side + 0.5 * t * (1 - t) * turn.dot(side) * outward, normal};
}

} // namespace

Vectors section_normals(const Vectors& points, const Triangles& triangles) {
  Vectors unit_normals = vertex_area_vectors(triangles, points, 0, static_cast<int>(points.size()));
  for (Vec3& n : unit_normals)
    n.normalize();
  return unit_normals;
}

double section_area(const Vectors& points, const Triangles& triangles, const Vectors& unit_normals, const Vec3& origin,
                    const Vec3& normal) {
  // mm^2: triangles further than 8 mm from the origin belong to other branches
  constexpr double local_radius_squared = 64.0;
  using Edge = std::pair<int, int>;
  const auto side = [&](int v) { return normal.dot(points[v] - origin); };
  std::map<Edge, Edge> next;
  std::map<Edge, PlaneCrossing> crossing;
  for (const Triangle& t : triangles) {
    if ((points[t[0]] - origin).squaredNorm() > local_radius_squared)
      continue;
    Edge enter, leave;
    int crossings = 0;
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      const double da = side(a), db = side(b);
      if ((da < 0) == (db < 0))
        continue;
      const Edge e{std::min(a, b), std::max(a, b)};
      crossing[e] = crossing_at(a, b, da / (da - db), points, unit_normals, normal);
      // On the way round the triangle, the plane is crossed upwards at `leave` and downwards at `enter`.
      (da < 0 ? leave : enter) = e;
      ++crossings;
    }
    if (crossings == 2)
      next[enter] = leave;
  }
  double best = 0, nearest = 1e300;
  while (!next.empty()) {
    const Edge first = next.begin()->first;
    Edge e = first;
    Vec3 area = Vec3::Zero(), centroid = Vec3::Zero();
    double length = 0, arc_area = 0; // mm; mm^2: area between arcs and chords, two thirds of chord times sagitta
    bool closed = false;
    while (true) {
      const auto it = next.find(e);
      if (it == next.end())
        break;
      const Edge to = it->second;
      next.erase(it);
      const Vec3 a = crossing[e].point - origin, b = crossing[to].point - origin;
      arc_area += (b - a).norm() / 12 * (crossing[to].normal - crossing[e].normal).dot(b - a);
      area += 0.5 * a.cross(b);
      centroid += (b - a).norm() * 0.5 * (a + b);
      length += (b - a).norm();
      e = to;
      if (e == first) {
        closed = true;
        break;
      }
    }
    if (closed && length > 0 && (centroid / length).norm() < nearest) {
      nearest = (centroid / length).norm();
      best = area.norm() + arc_area;
    }
  }
  return best;
}

double smallest_section(const Vectors& points, const Triangles& triangles, const Path& path, double s_start,
                        double s_end) {
  constexpr double spacing = 0.5; // mm
  const Vectors unit_normals = section_normals(points, triangles);
  const int n = std::max(1, static_cast<int>(std::lround((s_end - s_start) / spacing)));
  double smallest = 0;
  for (int k = 0; k <= n; ++k) {
    const double s = s_start + (s_end - s_start) * k / n;
    const double area = section_area(points, triangles, unit_normals, path.at(s), path.tangent(s));
    if (area > 0 && (smallest == 0 || area < smallest))
      smallest = area;
  }
  return smallest;
}

} // namespace vci
