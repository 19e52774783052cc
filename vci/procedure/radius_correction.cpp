#include "vci/procedure/radius_correction.hpp"
#include "vci/devices/balloon/balloon_chart.hpp"

#include <algorithm>
#include <cmath>

namespace vci {

namespace {

constexpr double blend_length = 3.0; // mm beyond a device's ends over which the original radius is reached

/// A span of a branch, and the radius that the lumen gets there.
struct SpanTarget {
  const Path* path;
  double s_start, s_end, radius; ///< mm
  double recoil_factor;          ///< final radius after recoil over the inflated radius
};

/// One target for each stent; the largest balloon inflated in the stent gives the radius. If the scene has no stent,
/// one target for each balloon.
std::vector<SpanTarget> targets_of(const Scene& scene, const std::map<std::string, Path>& paths) {
  std::vector<SpanTarget> stents, balloons;
  for (const Step& step : scene.procedure)
    for (const Placement& p : step.devices) {
      const StentSpec* stent = scene.stent(p.device);
      const BalloonSpec& b = scene.balloon(p.device);
      const BalloonChart chart(b.chart_pressure_bar, b.chart_diameter, b.crimped_diameter);
      const double length = scene.length(p.device);
      const SpanTarget t{&paths.at(p.branch), p.centre_s - 0.5 * length, p.centre_s + 0.5 * length,
                         0.5 * chart.diameter_at(p.pressure_bar), 1.0};
      if (stent) {
        const double recoil_factor = 1 - 0.01 * stent->recoil_percent;
        stents.push_back({t.path, t.s_start, t.s_end, recoil_factor * t.radius, recoil_factor});
      } else
        balloons.push_back(t);
    }
  for (SpanTarget& stent : stents)
    for (const SpanTarget& b : balloons) // centred in the stent's span
      if (b.path == stent.path && 0.5 * (b.s_start + b.s_end) > stent.s_start &&
          0.5 * (b.s_start + b.s_end) < stent.s_end)
        stent.radius = std::max(stent.radius, stent.recoil_factor * b.radius);
  return stents.empty() ? balloons : stents;
}

/// Share of the change of radius that is applied at arc length s (mm). It is 1 within the target's span. Beyond the
/// span's ends it falls to 0 over blend_length, as a cubic with zero end slopes.
double weight_at(double s, const SpanTarget& t) {
  const double beyond_span = std::max({t.s_start - s, s - t.s_end, 0.0}) / blend_length;
  return beyond_span >= 1 ? 0.0 : 1 - beyond_span * beyond_span * (3 - 2 * beyond_span);
}

/// Points along a branch's axis from s = 0 on, each with the radius (mm) of the largest sphere round it that holds no
/// point of the wall.
class InscribedSpheres {
public:
  InscribedSpheres(const Path& path, const Vectors& wall) {
    const int steps = std::max(1, static_cast<int>(std::lround(path.end() / spacing)));
    for (int k = 0; k <= steps; ++k) {
      points_.push_back(path.at(path.end() * k / steps));
      double nearest = 1e300;
      for (const Vec3& p : wall)
        nearest = std::min(nearest, (p - points_.back()).squaredNorm());
      radius_.push_back(std::sqrt(nearest));
    }
    step_ = path.end() / steps;
  }
  double radius_at(double s) const {
    const double place = std::clamp(s / step_, 0.0, static_cast<double>(points_.size() - 1));
    const auto k = std::min(static_cast<std::size_t>(place), points_.size() - 2);
    const double t = place - static_cast<double>(k);
    return (1 - t) * radius_[k] + t * radius_[k + 1];
  }
  /// Distance (mm) of p from the nearest of these spheres; negative inside a sphere.
  double distance_outside(const Vec3& p) const {
    double least = 1e300;
    for (std::size_t k = 0; k < points_.size(); ++k)
      least = std::min(least, (p - points_[k]).norm() - radius_[k]);
    return least;
  }

private:
  static constexpr double spacing = 0.25; ///< distance between the points, mm
  Vectors points_;
  std::vector<double> radius_;
  double step_;
};

/// Arc length (mm) at which the path's cross-section contains p, searched from `first` to `last` (mm). A cross-section
/// is perpendicular to a chord of 1 mm of the path. If it were perpendicular to a single piece of the polyline, a wall
/// that moves far outwards would cross itself at the polyline's corners.
double section_arc_length(const Vec3& p, const Path& path, double first, double last) {
  double nearest = 1e300, place = 0;
  for (double s = first; s <= last; s += 0.1)
    if (const double d = (p - path.at(s)).squaredNorm(); d < nearest) {
      nearest = d;
      place = s;
    }
  double low = place - 0.5, high = place + 0.5;
  for (int k = 0; k < 40; ++k) {
    const double middle = 0.5 * (low + high);
    ((p - path.at(middle)).dot(path.tangent(middle)) > 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// New distance (mm) from the axis for a wall point at distance r. The wall of the branch itself moves from `radius` to
/// `target`. Walls of other branches, farther out, move by a share that fades to 0 over twice the change of radius. The
/// new distance increases with r, so that no wall passes through another.
double new_distance(double r, double radius, double target, bool own_wall) {
  if (own_wall)
    return target;
  const double change = target - radius;
  const double beyond = std::max(0.0, r - radius) / std::max(2 * std::abs(change), 1e-9);
  return r + change * std::max(0.0, 1 - beyond);
}

} // namespace

Vectors correct_radius(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& paths) {
  Vectors points = lumen.points;
  std::vector<char> cap(points.size(), 0);
  for (std::size_t k = 0; k < lumen.triangles.size(); ++k)
    if (lumen.region[k] != 0)
      for (int v : lumen.triangles[k])
        cap[v] = 1;
  std::map<const Path*, InscribedSpheres> spheres;
  for (const auto& [name, path] : paths)
    spheres.emplace(&path, InscribedSpheres(path, lumen.points));
  for (const SpanTarget& t : targets_of(scene, paths)) {
    const InscribedSpheres& own_spheres = spheres.at(t.path);
    const double first = t.s_start - blend_length, last = t.s_end + blend_length;
    for (std::size_t v = 0; v < points.size(); ++v) {
      if (cap[v])
        continue;
      const double place = section_arc_length(points[v], *t.path, first, last);
      const Vec3 ray = points[v] - t.path->at(place);
      const double r = ray.norm(), radius = own_spheres.radius_at(place);
      if (place <= first || place >= last || r > 3 * std::max(radius, t.radius) || r < 1e-6)
        continue;
      bool own_wall = true;
      for (const auto& [path, other] : spheres)
        own_wall = own_wall && (path == t.path || other.distance_outside(lumen.points[v]) > r - radius - 0.1 * radius);
      points[v] += weight_at(place, t) * (new_distance(r, radius, t.radius, own_wall) - r) * ray / r;
    }
  }
  return points;
}

} // namespace vci
