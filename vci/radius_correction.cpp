#include "vci/radius_correction.hpp"

#include <algorithm>
#include <cmath>

namespace vci {

namespace {

constexpr double blend_length = 3.0; // mm beyond the device's ends

struct Target {
  const Path* path;
  double s_start, s_end, radius;
  double keeps; ///< share of the inflated radius after recoil
};

/// One target per stent, with the largest balloon that was inflated inside it; balloons alone count where no stent is.
std::vector<Target> targets_of(const Scene& scene, const std::map<std::string, Path>& paths) {
  std::vector<Target> stents, balloons;
  for (const Step& step : scene.procedure)
    for (const Placement& p : step.devices) {
      const bool stent = scene.stents.contains(p.device);
      const BalloonSpec& b = scene.balloons.at(stent ? scene.stents.at(p.device).balloon : p.device);
      const BalloonChart chart(b.chart_pressure_bar, b.chart_diameter, b.crimped_diameter);
      const double length = stent ? scene.stents.at(p.device).length : b.length;
      const Target t{&paths.at(p.branch), p.centre_s - 0.5 * length, p.centre_s + 0.5 * length,
                     0.5 * chart.diameter_at(p.pressure_bar), 1.0};
      if (stent) {
        const double keeps = 1 - 0.01 * scene.stents.at(p.device).recoil_percent;
        stents.push_back({t.path, t.s_start, t.s_end, keeps * t.radius, keeps});
      } else
        balloons.push_back(t);
    }
  for (Target& stent : stents)
    for (const Target& b : balloons) // centred in the stent's span
      if (b.path == stent.path && 0.5 * (b.s_start + b.s_end) > stent.s_start &&
          0.5 * (b.s_start + b.s_end) < stent.s_end)
        stent.radius = std::max(stent.radius, stent.keeps * b.radius);
  return stents.empty() ? balloons : stents;
}

/// Clamped cubic from 1 at the span to 0 at blend_length beyond it.
double weight_at(double s, const Target& t) {
  const double outside = std::max({t.s_start - s, s - t.s_end, 0.0}) / blend_length;
  return outside >= 1 ? 0.0 : 1 - outside * outside * (3 - 2 * outside);
}

} // namespace

Vectors correct_radius(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& paths) {
  Vectors points = lumen.points;
  std::vector<char> cap(points.size(), 0);
  for (std::size_t k = 0; k < lumen.triangles.size(); ++k)
    if (lumen.region[k] != 0)
      for (int v : lumen.triangles[k])
        cap[v] = 1;
  for (const Target& t : targets_of(scene, paths)) {
    const double first = t.s_start - blend_length, last = t.s_end + blend_length;
    for (std::size_t v = 0; v < points.size(); ++v) {
      if (cap[v])
        continue;
      double nearest = 1e300, place = 0;
      for (double s = first; s <= last; s += 0.1)
        if (const double d = (points[v] - t.path->at(s)).squaredNorm(); d < nearest) {
          nearest = d;
          place = s;
        }
      const Vec3 ray = points[v] - t.path->at(place);
      const double r = ray.norm();
      // points of other branches lie beyond the branch's own lumen
      if (place <= first + 0.1 || place >= last - 0.1 || r > 1.3 * std::max(lumen.radius[v], t.radius) || r < 1e-6)
        continue;
      points[v] += weight_at(place, t) * (t.radius - r) * ray / r;
    }
  }
  return points;
}

} // namespace vci
