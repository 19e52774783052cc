#include "vci/sections.hpp"

#include <Eigen/Geometry>
#include <map>
#include <utility>

namespace vci {

double section_area(const Vectors& points, const Triangles& triangles, const Vec3& origin, const Vec3& normal) {
  constexpr double local = 64.0; // mm^2: loops further than 8 mm from the axis belong to other branches
  using Edge = std::pair<int, int>;
  const auto side = [&](int v) { return normal.dot(points[v] - origin); };
  std::map<Edge, Edge> next;
  std::map<Edge, Vec3> crossing;
  for (const Triangle& t : triangles) {
    if ((points[t[0]] - origin).squaredNorm() > local)
      continue;
    Edge enter, leave;
    int crossings = 0;
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      const double da = side(a), db = side(b);
      if ((da < 0) == (db < 0))
        continue;
      const Edge e{std::min(a, b), std::max(a, b)};
      crossing[e] = points[a] + da / (da - db) * (points[b] - points[a]);
      (da < 0 ? leave : enter) = e; // along the triangle's outline: up through `leave`, down through `enter`
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
    double length = 0;
    bool closed = false;
    while (true) {
      const auto it = next.find(e);
      if (it == next.end())
        break;
      const Edge to = it->second;
      next.erase(it);
      const Vec3 a = crossing[e] - origin, b = crossing[to] - origin;
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
      best = area.norm();
    }
  }
  return best;
}

} // namespace vci
