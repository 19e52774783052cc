#include "vci/geometry/surface.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace vci {

namespace {

struct Side {
  int from, to, opposite;
};

/// The sides of all triangles, by their two vertices in ascending order. The map makes the order of edges reproducible.
std::map<std::pair<int, int>, std::vector<Side>> sides_of(const Triangles& triangles) {
  std::map<std::pair<int, int>, std::vector<Side>> sides;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      sides[{std::min(a, b), std::max(a, b)}].push_back({a, b, t[(k + 2) % 3]});
    }
  return sides;
}

} // namespace

std::vector<InteriorEdge> interior_edges(const Triangles& triangles, const Vectors& points) {
  std::vector<InteriorEdge> edges;
  for (const auto& [key, list] : sides_of(triangles)) {
    if (list.size() != 2 || list[0].from != list[1].to)
      continue;
    const double length = (points[key.second] - points[key.first]).norm();
    edges.push_back({list[0].from, list[0].to, list[0].opposite, list[1].opposite, length});
  }
  return edges;
}

std::vector<char> boundary_vertices(const Triangles& triangles, int vertex_count) {
  std::vector<char> boundary(vertex_count, 0);
  for (const auto& [key, list] : sides_of(triangles))
    if (list.size() == 1)
      boundary[key.first] = boundary[key.second] = 1;
  return boundary;
}

double winding_number(const Vec3& p, const Triangles& triangles, const Vectors& x) {
  // sum of half the solid angles of the triangles seen from p (van Oosterom and Strackee, IEEE TBME 30(2), 1983)
  double half_angles = 0;
  for (const Triangle& t : triangles) {
    const Vec3 a = x[t[0]] - p, b = x[t[1]] - p, c = x[t[2]] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    half_angles += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return half_angles / (2 * pi);
}

Vectors vertex_area_vectors(const Triangles& triangles, const Vectors& x, int first, int count) {
  Vectors areas(count, Vec3::Zero());
  for (const Triangle& t : triangles) {
    const Vec3 third = area_vector(t, x) / 3.0;
    for (int v : t)
      areas[v - first] += third;
  }
  return areas;
}

namespace {

/// (n_j - n_i) . (x_j - x_i) / 2 along a side from i to j (mm). Its size is limited to the value at the side of a
/// regular hexagon, because the normals of a crumpled surface do not give its curvature.
double sagitta_coefficient(int i, int j, const Vectors& x, const Vectors& unit_normals) {
  const Vec3 side = x[j] - x[i];
  const double limit = 0.5 * side.norm();
  return std::clamp(0.5 * (unit_normals[j] - unit_normals[i]).dot(side), -limit, limit);
}

} // namespace

double sagitta(const Triangle& t, const Vec3& weights, const Vectors& x, const Vectors& unit_normals) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const int j = (k + 1) % 3;
    sum += weights[k] * weights[j] * sagitta_coefficient(t[k], t[j], x, unit_normals);
  }
  return sum;
}

double largest_sagitta(const Triangle& t, const Vectors& x, const Vectors& unit_normals) {
  double sum = 0;
  for (int k = 0; k < 3; ++k)
    sum += 0.25 * std::abs(sagitta_coefficient(t[k], t[(k + 1) % 3], x, unit_normals));
  return sum;
}

std::vector<std::vector<int>> vertex_neighbours(const Triangles& triangles, int vertex_count) {
  std::vector<std::vector<int>> neighbours(vertex_count);
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) {
      neighbours[t[k]].push_back(t[(k + 1) % 3]);
      neighbours[t[k]].push_back(t[(k + 2) % 3]);
    }
  for (auto& list : neighbours) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return neighbours;
}

} // namespace vci
