#include "vci/scene/checks/surface_check.hpp"
#include "common/error.hpp"
#include "vci/geometry/surface.hpp"

#include <algorithm>
#include <numeric>
#include <sstream>
#include <tuple>
#include <utility>

namespace vci {

namespace {

// Least height of a triangle over its longest edge. Lumens from the anatomy step have at least 0.1, the benchmarks'
// sliver triangles 0.2.
constexpr double least_height_ratio = 1e-6;

std::string location_text(const std::string& file, const char* what, std::size_t number, const Vec3& at) {
  std::ostringstream text;
  text << file << ": " << what << ' ' << number << " at (" << at[0] << ", " << at[1] << ", " << at[2] << ") mm";
  return text.str();
}

void refuse_coincident_points(const Lumen& lumen, const std::string& file) {
  std::vector<int> order(lumen.points.size());
  std::iota(order.begin(), order.end(), 0);
  const auto coordinates = [&](int i) {
    const Vec3& p = lumen.points[i];
    return std::array<double, 3>{p[0], p[1], p[2]};
  };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return coordinates(a) < coordinates(b); });
  int repeats = 0, first = -1, second = -1;
  for (std::size_t k = 1; k < order.size(); ++k)
    if (coordinates(order[k - 1]) == coordinates(order[k])) {
      if (repeats++ == 0) {
        first = order[k - 1];
        second = order[k];
      }
    }
  if (repeats > 0)
    throw common::InputError("two points of the lumen are in one place", point_location(lumen, first, file),
                             "point " + std::to_string(second) + " is there, too; " + std::to_string(repeats) +
                                 " such in all",
                             "merge them: triangles that meet must share their points");
}

void refuse_flat_triangles(const Lumen& lumen, const std::string& file) {
  for (std::size_t k = 0; k < lumen.triangles.size(); ++k) {
    const Triangle& t = lumen.triangles[k];
    double longest = 0;
    for (int c = 0; c < 3; ++c)
      longest = std::max(longest, (lumen.points[t[(c + 1) % 3]] - lumen.points[t[c]]).squaredNorm());
    const double area = area_vector(t, lumen.points).norm();
    if (!(2 * area > least_height_ratio * longest))
      throw common::InputError("a triangle of the lumen has no area", triangle_location(lumen, k, file),
                               "points " + std::to_string(t[0]) + ", " + std::to_string(t[1]) + ", " +
                                   std::to_string(t[2]) + ": " + std::to_string(area) + " mm2",
                               "remove it, or remesh the lumen with the anatomy step");
  }
}

void refuse_triangles_given_twice(const Lumen& lumen, const std::string& file) {
  std::vector<std::pair<Triangle, std::size_t>> sorted;
  for (std::size_t k = 0; k < lumen.triangles.size(); ++k) {
    Triangle t = lumen.triangles[k];
    std::sort(t.begin(), t.end());
    sorted.emplace_back(t, k);
  }
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t k = 1; k < sorted.size(); ++k)
    if (sorted[k - 1].first == sorted[k].first)
      throw common::InputError(
          "a triangle of the lumen is given twice", triangle_location(lumen, sorted[k - 1].second, file),
          "triangle " + std::to_string(sorted[k].second) + " has the same points", "leave one of the two");
}

/// A side of a triangle, with its two points in ascending order.
struct Side {
  int low, high;
  std::size_t triangle;
  bool ascending; ///< whether the triangle's order of corners goes from `low` to `high`
  bool same_edge(const Side& other) const { return low == other.low && high == other.high; }
};

std::vector<Side> sorted_sides(const Triangles& triangles) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t k = 0; k < triangles.size(); ++k)
    for (int c = 0; c < 3; ++c) {
      const int a = triangles[k][c], b = triangles[k][(c + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), k, a < b});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return sides;
}

/// Calls visit(first side, number of sides) for each edge. The sides of an edge follow one another in the sorted list.
template <class Visit> void for_each_edge(const std::vector<Side>& sides, Visit&& visit) {
  for (std::size_t k = 0, end = 0; k < sides.size(); k = end) {
    for (end = k + 1; end < sides.size() && sides[end].same_edge(sides[k]);)
      ++end;
    visit(&sides[k], end - k);
  }
}

void refuse_unoriented_surface(const Lumen& lumen, const std::vector<Side>& sides, const std::string& file) {
  // for each triangle the number of neighbours that face the opposite side
  std::vector<int> opposed_neighbours(lumen.triangles.size(), 0);
  int edges = 0;
  for_each_edge(sides, [&](const Side* side, std::size_t count) {
    if (count > 2)
      throw common::InputError("more than two triangles of the lumen meet in one edge",
                               triangle_location(lumen, side->triangle, file),
                               std::to_string(count) + " triangles at points " + std::to_string(side->low) + " and " +
                                   std::to_string(side->high),
                               "repair the surface with the anatomy step (build/lumen process)");
    if (count == 2 && side[0].ascending == side[1].ascending) {
      ++opposed_neighbours[side[0].triangle];
      ++opposed_neighbours[side[1].triangle];
      ++edges;
    }
  });
  if (edges == 0)
    return;
  const auto most = std::max_element(opposed_neighbours.begin(), opposed_neighbours.end());
  throw common::InputError("triangles of the lumen are turned against their neighbours",
                           triangle_location(lumen, static_cast<std::size_t>(most - opposed_neighbours.begin()), file),
                           std::to_string(*most) + " neighbours of this one, " + std::to_string(edges) +
                               " edges in all",
                           "turn all triangles outward");
}

/// For each point the next point along the open edge of the wall, in the direction of the triangle there; -1 for points
/// that lie on no open edge. Edges between wall and cap count as open.
std::vector<int> next_on_rim(const Lumen& lumen, const std::vector<Side>& sides, const std::string& file) {
  std::vector<int> next(lumen.points.size(), -1);
  for_each_edge(sides, [&](const Side* side, std::size_t count) {
    const auto of_wall = [&](const Side& s) { return lumen.region[s.triangle] == 0; };
    if (count == 1 ? !of_wall(side[0]) : of_wall(side[0]) == of_wall(side[1]))
      return;
    const Side& open = of_wall(side[0]) ? side[0] : side[1];
    const int from = open.ascending ? open.low : open.high;
    if (next[from] >= 0)
      throw common::InputError("two openings of the lumen's wall meet in one point", point_location(lumen, from, file),
                               "four open edges end there", "close the wall there, or cut the vessel's end anew");
    next[from] = open.ascending ? open.high : open.low;
  });
  return next;
}

void refuse_several_pieces(const Lumen& lumen, const std::string& file) {
  std::vector<int> parent(lumen.points.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int v) {
    while (parent[v] != v)
      v = parent[v] = parent[parent[v]];
    return v;
  };
  std::vector<std::size_t> size(lumen.points.size(), 0);
  for (const Triangle& t : lumen.triangles)
    for (int c = 1; c < 3; ++c)
      parent[root(t[c])] = root(t[0]);
  int main_piece = root(lumen.triangles.front()[0]);
  for (const Triangle& t : lumen.triangles)
    if (const int own = root(t[0]); ++size[own] > size[main_piece])
      main_piece = own;
  for (std::size_t k = 0; k < lumen.triangles.size(); ++k)
    if (const int own = root(lumen.triangles[k][0]); own != main_piece)
      throw common::InputError("the lumen is in pieces", triangle_location(lumen, k, file),
                               "a piece of " + std::to_string(size[own]) + " of its " +
                                   std::to_string(lumen.triangles.size()) + " triangles",
                               "join the pieces where they share no points, remove what is no vessel");
}

} // namespace

std::string triangle_location(const Lumen& lumen, std::size_t triangle, const std::string& file) {
  const Triangle& t = lumen.triangles[triangle];
  return location_text(file, "triangle", triangle, (lumen.points[t[0]] + lumen.points[t[1]] + lumen.points[t[2]]) / 3);
}

std::string point_location(const Lumen& lumen, int point, const std::string& file) {
  return location_text(file, "point", static_cast<std::size_t>(point), lumen.points[point]);
}

std::vector<Rim> checked_rims(const Lumen& lumen, const std::string& file) {
  refuse_coincident_points(lumen, file);
  refuse_flat_triangles(lumen, file);
  refuse_triangles_given_twice(lumen, file);
  const std::vector<Side> sides = sorted_sides(lumen.triangles);
  refuse_unoriented_surface(lumen, sides, file);
  std::vector<int> next = next_on_rim(lumen, sides, file);
  refuse_several_pieces(lumen, file);
  std::vector<Rim> rims;
  for (std::size_t v = 0; v < next.size(); ++v) {
    if (next[v] < 0)
      continue;
    Rim rim;
    for (int at = static_cast<int>(v); next[at] >= 0; at = std::exchange(next[at], -1))
      rim.push_back(at);
    rims.push_back(std::move(rim));
  }
  return rims;
}

} // namespace vci
