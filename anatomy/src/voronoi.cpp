#include "voronoi.hpp"
#include "common/error.hpp"
#include "inner_balls.hpp"
#include <algorithm>

namespace anatomy {

std::vector<Path> voronoi_paths(const Mesh& mesh, const std::vector<End>& ends, std::size_t inlet) {
  const Balls balls = inner_balls(mesh, ends);
  const std::size_t from = ball_at(balls, ends[inlet]);
  const std::vector<std::size_t> before = cheapest_ways(balls, from);
  std::vector<Path> paths(ends.size());
  for (std::size_t e = 0; e < ends.size(); ++e) {
    if (e == inlet)
      continue;
    std::size_t at = ball_at(balls, ends[e]);
    for (; at != from && at != balls.centre.size(); at = before[at]) {
      paths[e].points.push_back(balls.centre[at]);
      paths[e].radius.push_back(balls.radius[at]);
    }
    if (at != from)
      throw common::ComputationError("no way through the lumen from the inlet to an end", place(ends[e].centre),
                                     std::to_string(balls.centre.size()) + " inscribed balls",
                                     "use a smaller edge: the lumen is too narrow for it somewhere");
    paths[e].points.push_back(balls.centre[from]);
    paths[e].radius.push_back(balls.radius[from]);
    std::reverse(paths[e].points.begin(), paths[e].points.end());
    std::reverse(paths[e].radius.begin(), paths[e].radius.end());
  }
  return paths;
}

} // namespace anatomy
