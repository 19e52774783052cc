#include "vci/apposition.hpp"
#include "vci/closest_point.hpp"
#include "vci/contact.hpp"

namespace vci {

namespace {

constexpr double reach = 2.0; // mm: a stent further from the wall faces something else

/// Gap (mm) from a wall vertex to a stent, 0 where its foot lies on the stent's end.
double gap_to(const System& system, const Body& stent, const Vectors& normals, const Vec3& p) {
  double nearest = 1e300, gap = 0;
  for (const Triangle& t : stent.triangles) {
    if ((system.x[t[0]] - p).squaredNorm() > reach * reach)
      continue;
    const ClosestPoint c = closest_on_triangle(p, system.x[t[0]], system.x[t[1]], system.x[t[2]]);
    if (c.distance_squared >= nearest)
      continue;
    nearest = c.distance_squared;
    const Vec3 foot = c.weights[0] * system.x[t[0]] + c.weights[1] * system.x[t[1]] + c.weights[2] * system.x[t[2]];
    gap = c.weights.minCoeff() > 0 ? (p - foot).dot(normals[t[0]].normalized()) : 0.0;
  }
  return std::max(0.0, gap);
}

} // namespace

std::vector<double> malapposition(const System& system, const std::string& stent) {
  const Body& wall = system.body(0);
  const Vectors normals = area_vectors(system);
  std::vector<double> gaps(wall.count, 0.0);
  for (int b = 1; b < system.bodies(); ++b)
    for (int i = 0; system.body(b).name == stent && i < wall.count; ++i)
      gaps[i] = std::max(gaps[i], gap_to(system, system.body(b), normals, system.x[i]));
  return gaps;
}

} // namespace vci
