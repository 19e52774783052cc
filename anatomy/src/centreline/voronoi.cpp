#include "centreline/voronoi.hpp"
#include "centreline/inscribed_spheres.hpp"
#include "common/error.hpp"
#include <algorithm>

namespace anatomy {
namespace {

// Largest number of spheres compared on each side of a gap. Spheres lie densely, so a sample of them finds the gap.
constexpr std::size_t most_compared_spheres = 3000;

// The point (mm) midway between the two nearest centres, of a sphere connected to the inlet and of one connected to the
// sphere `end`.
Vec3 narrowest_gap(const InscribedSpheres& spheres, const ShortestPaths& from_inlet, std::size_t end) {
  const ShortestPaths from_end = cheapest_paths(spheres, end);
  std::vector<Vec3> near_inlet, near_end;
  for (std::size_t i = 0; i < spheres.centre.size(); ++i)
    if (from_inlet.cost[i] < unreached)
      near_inlet.push_back(spheres.centre[i]);
    else if (from_end.cost[i] < unreached)
      near_end.push_back(spheres.centre[i]);
  const auto step = [](const std::vector<Vec3>& x) { return x.size() / most_compared_spheres + 1; };
  double nearest = unreached;
  Vec3 place = spheres.centre[end];
  for (std::size_t i = 0; i < near_inlet.size(); i += step(near_inlet))
    for (std::size_t j = 0; j < near_end.size(); j += step(near_end))
      if (const double d = (near_inlet[i] - near_end[j]).squaredNorm(); d < nearest) {
        nearest = d;
        place = 0.5 * (near_inlet[i] + near_end[j]);
      }
  return place;
}

} // namespace

std::vector<Path> voronoi_paths(const Mesh& mesh, const std::vector<End>& ends, std::size_t inlet) {
  const InscribedSpheres spheres = inscribed_spheres(mesh, ends);
  const std::size_t from = sphere_at_end(spheres, ends[inlet]);
  const ShortestPaths cheapest = cheapest_paths(spheres, from);
  std::vector<Path> paths(ends.size());
  for (std::size_t e = 0; e < ends.size(); ++e) {
    if (e == inlet)
      continue;
    std::size_t at = sphere_at_end(spheres, ends[e]);
    if (cheapest.cost[at] >= unreached)
      throw common::ComputationError(
          "no way through the lumen from the inlet to an end",
          "near " + point_text(narrowest_gap(spheres, cheapest, at)),
          std::to_string(spheres.centre.size()) + " inscribed balls, none on the way to " + point_text(ends[e].centre),
          "the lumen is closed there, or too narrow to follow: open it in the segmentation, or leave what lies behind "
          "it "
          "away by --cut x,y,z before that place");
    for (; at != from; at = cheapest.previous[at]) {
      paths[e].points.push_back(spheres.centre[at]);
      paths[e].radius.push_back(spheres.radius[at]);
    }
    paths[e].points.push_back(spheres.centre[from]);
    paths[e].radius.push_back(spheres.radius[from]);
    std::reverse(paths[e].points.begin(), paths[e].points.end());
    std::reverse(paths[e].radius.begin(), paths[e].radius.end());
  }
  return paths;
}

} // namespace anatomy
