#include "vci/procedure/region.hpp"
#include "vci/geometry/axis_search.hpp"

#include <algorithm>
#include <cmath>

namespace vci {

namespace {

/// For each point the branch whose axis is nearest, and the arc length (mm) of the nearest place on that axis. The
/// distance has no limit: the far walls of a flat lumen lie many radii from the axis, and still belong to the branch.
std::vector<std::pair<std::string, double>> nearest_branches(const Vectors& points,
                                                             const std::map<std::string, Path>& paths) {
  std::map<std::string, AxisSearch> axes;
  for (const auto& [name, path] : paths)
    axes.emplace(name, AxisSearch(path));
  std::vector<std::pair<std::string, double>> found;
  for (const Vec3& p : points) {
    double distance = 1e300;
    found.emplace_back();
    for (auto& [name, axis] : axes) {
      const AxisPoint place = axis.nearest(p);
      if (const double d = (p - place.point).norm(); d < distance) {
        distance = d;
        found.back() = {name, place.s};
      }
    }
  }
  return found;
}

} // namespace

std::vector<char> region_of_interest(const Lumen& lumen, const Scene& scene, const std::map<std::string, Path>& paths) {
  std::vector<char> may_move(lumen.points.size(), 0);
  const auto nearest = nearest_branches(lumen.points, paths);
  const double margin = scene.numerics.region_margin;
  for (const Step& step : scene.procedure)
    for (const Placement& p : step.devices) {
      const BalloonSpec& balloon = scene.balloon(p.device);
      const double half = 0.5 * scene.opened_length(p.device) + balloon.shoulder;
      const double reach = 0.5 * balloon.nominal_diameter + margin; // from the axis
      for (std::size_t v = 0; v < lumen.points.size(); ++v)
        if (nearest[v].first == p.branch && std::abs(nearest[v].second - p.centre_s) < half + margin)
          may_move[v] = 1;
      // A device also moves the walls of other branches beside it: their mouths, and what lies behind a carina.
      for (double s = p.centre_s - half; s <= p.centre_s + half; s += 0.5) {
        const Vec3 centre = paths.at(p.branch).at(s);
        for (std::size_t v = 0; v < lumen.points.size(); ++v)
          if (nearest[v].first != p.branch && (lumen.points[v] - centre).norm() < reach)
            may_move[v] = 1;
      }
    }
  return may_move;
}

std::vector<char> points_beside(const Vectors& points, const std::map<std::string, Path>& paths,
                                const std::string& branch, double from, double to) {
  constexpr double shared_axis_tolerance = 0.1; // mm: two branches may have different points on a stretch they share
  const auto nearest = nearest_branches(points, paths);
  AxisSearch axis(paths.at(branch));
  std::vector<char> flags(points.size(), 0);
  for (std::size_t v = 0; v < points.size(); ++v) {
    const AxisPoint own = axis.nearest(points[v]);
    const auto& [name, s] = nearest[v];
    const double least = (points[v] - paths.at(name).at(s)).norm();
    flags[v] = own.s >= from && own.s <= to && (points[v] - own.point).norm() <= least + shared_axis_tolerance;
  }
  return flags;
}

} // namespace vci
