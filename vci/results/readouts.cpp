#include "vci/results/readouts.hpp"
#include "vci/geometry/sections.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <sstream>

namespace vci {

using nlohmann::json;

namespace {

Segment span_of(const Scene& scene, const Placement& p) {
  const double length = scene.length(p.device);
  return {p.branch, p.centre_s - 0.5 * length, p.centre_s + 0.5 * length};
}

/// Mean healthy lumen area (mm^2) along the segment, from the reference radii of the wall's points there; 0 if unknown.
double reference_area(const Lumen& lumen, const Path& path, const Segment& segment) {
  if (lumen.reference_radius.empty())
    return 0;
  double sum = 0;
  int count = 0;
  for (std::size_t v = 0; v < lumen.points.size(); ++v)
    for (double s = segment.s_start; s <= segment.s_end; s += 1.0)
      if ((lumen.points[v] - path.at(s)).norm() < lumen.radius[v] + 0.5) {
        const double r = lumen.reference_radius[v];
        sum += pi * r * r;
        ++count;
        break;
      }
  return count > 0 ? sum / count : 0;
}

/// Peak memory of this process, MiB; 0 if the system does not report it. (getrusage would include the memory of the
/// program from which the process was forked.)
double peak_memory_mib() {
  std::ifstream status("/proc/self/status");
  std::string key;
  for (double kib = 0; status >> key;)
    if (key == "VmHWM:" && status >> kib)
      return kib / 1024;
  return 0;
}

/// The value under `key` that comes first in the order `before`: by default the smallest. Null values are left out. The
/// result is null if no row has a value.
template <class Order = std::less<>>
json first_in_order(const json& rows, const char* key = "area_mm2", Order before = {}) {
  json smallest = nullptr;
  for (const json& row : rows)
    if (!row[key].is_null() && (smallest.is_null() || before(row[key], smallest)))
      smallest = row[key];
  return smallest;
}

/// Arc length (mm) at which a path is nearest to a point, within `reach` (mm) of the arc length s.
double nearest_arc_length(const Path& path, const Vec3& p, double s, double reach) {
  constexpr int steps = 2000;
  double place = s, nearest = 1e300;
  for (int k = 0; k <= steps; ++k) {
    const double at = s + reach * (2.0 * k / steps - 1);
    if (const double d = (path.at(at) - p).squaredNorm(); d < nearest) {
      nearest = d;
      place = at;
    }
  }
  return place;
}

/// The smallest lumen area (mm^2) between a deployed stent's ends; null if there is no section. Planes within half a
/// millimetre of an end are left out. There the stent's edge may be oblique, so that a plane would cut bare vessel too.
/// @param length length of the stent, mm
json lumen_area_in_stent(const StentHistory& h, double length, const DeploymentResult& d, const Triangles& triangles) {
  constexpr double end_margin = 0.5; // mm
  const Path& path = d.paths.at(h.branch);
  const double one = nearest_arc_length(path, h.first_end, h.centre_s, length),
               other = nearest_arc_length(path, h.last_end, h.centre_s, length);
  const double start = std::min(one, other) + end_margin, end = std::max(one, other) - end_margin;
  return start < end ? smallest_area(area_profile(d.points, triangles, path, start, end)) : json(nullptr);
}

/// Straightening (degrees) of the axis along the segment: the decrease of the total angle Path::turning(). The pieces
/// of the axis are as long as the lumen's mean diameter in the profile, but at least 1 mm.
double straightening_degrees(const Path& before, const Path& after, const Segment& s, const json& profile) {
  double area = 0;
  for (const json& row : profile)
    area += (row["area_mm2"].is_null() ? 0.0 : row["area_mm2"].get<double>()) / static_cast<double>(profile.size());
  const double piece_length = std::max(1.0, 2 * std::sqrt(area / pi));
  return (before.turning(s.s_start, s.s_end, piece_length) - after.turning(s.s_start, s.s_end, piece_length)) * 180.0 /
         pi;
}

} // namespace

Segment reported_segment(const Scene& scene) {
  if (scene.segment)
    return *scene.segment;
  for (const Step& step : scene.procedure)
    for (const Placement& p : step.devices)
      if (scene.stents.contains(p.device))
        return span_of(scene, p);
  return span_of(scene, scene.procedure.front().devices.front());
}

/// Numbers of the triangles of which a vertex has moved. Only their crossings are of the procedure's making.
std::vector<int> moved_triangles(const Lumen& lumen, const Vectors& points) {
  std::vector<int> moved;
  for (std::size_t k = 0; k < lumen.triangles.size(); ++k) {
    const Triangle& t = lumen.triangles[k];
    if (std::any_of(t.begin(), t.end(), [&](int v) { return points[v] != lumen.points[v]; }))
      moved.push_back(static_cast<int>(k));
  }
  return moved;
}

std::string crossing_warning(const Crossings& found) {
  std::ostringstream text;
  text << "the wall is folded: " << found.pairs << " pairs of its triangles cross, first at (" << found.first.x()
       << ", " << found.first.y() << ", " << found.first.z() << ") mm; do not trust areas and flow there";
  return text.str();
}

std::vector<std::string> warnings_of_outcome(const json& stents, double malapposition_mm, const OutcomeLimits& limits) {
  std::vector<std::string> warnings;
  for (const json& stent : stents)
    if (const json& index = stent["expansion_index"]; !index.is_null() && index < limits.least_expansion) {
      std::ostringstream text;
      text << stent["device"].get<std::string>() << " is under-expanded: its smallest area is "
           << 100 * index.get<double>() << " % of the healthy area, less than " << 100 * limits.least_expansion << " %";
      warnings.push_back(text.str());
    }
  if (malapposition_mm > limits.largest_malapposition) {
    std::ostringstream text;
    text << "malapposition: a stent stands " << malapposition_mm << " mm off the wall, more than "
         << limits.largest_malapposition << " mm";
    warnings.push_back(text.str());
  }
  return warnings;
}

json area_profile(const Vectors& points, const Triangles& triangles, const Path& path, double s_start, double s_end) {
  json profile = json::array();
  const Vectors unit_normals = section_normals(points, triangles);
  const int n = std::max(1, static_cast<int>(std::lround((s_end - s_start) / 0.5)));
  for (int k = 0; k <= n; ++k) {
    const double s = s_start + (s_end - s_start) * k / n;
    const double area = section_area(points, triangles, unit_normals, path.at(s), path.tangent(s));
    profile.push_back({{"s_mm", s}, {"area_mm2", area > 0 ? json(area) : json(nullptr)}});
  }
  return profile;
}

json smallest_area(const json& profile) {
  return first_in_order(profile);
}

json readouts(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& before,
              const DeploymentResult& d) {
  json out{{"schema", "vci-deployment-1"},
           {"case", scene.case_name},
           {"status", scene.numerics.integrator.textbook ? "at rest" : "converged"},
           {"method", "vci deploy"}};
  double total = 0;
  out["stages"] = json::array();
  for (const StageReport& s : d.stages) {
    total += s.seconds;
    out["stages"].push_back({{"step", s.step},
                             {"stage", s.stage},
                             {"seconds", s.seconds},
                             {"steps", s.result.steps},
                             {"careful_from", s.result.careful_from < 0 ? json(nullptr) : json(s.result.careful_from)},
                             {"cg_iterations", s.result.cg_iterations},
                             {"residual", s.result.residual},
                             {"contacts", s.result.contacts},
                             {"max_penetration_mm", s.result.maximal_penetration},
                             {"mean_penetration_mm", s.result.mean_penetration}});
  }
  out["settings"] = scene.settings;
  out["switched_off"] = d.switched_off;
  out["warnings"] = d.warnings;
  out["wall_vertices"] = d.vertices;
  out["seconds"] = total;
  out["peak_memory_mib"] = peak_memory_mib();

  const Segment segment = reported_segment(scene);
  out["segment"] = {{"branch", segment.branch}, {"s_start_mm", segment.s_start}, {"s_end_mm", segment.s_end}};
  const Path &path_before = before.at(segment.branch), &path_after = d.paths.at(segment.branch);
  out["csa_profile_before"] = area_profile(lumen.points, lumen.triangles, path_before, segment.s_start, segment.s_end);
  out["csa_profile"] = area_profile(d.points, lumen.triangles, path_after, segment.s_start, segment.s_end);
  out["minimal_lumen_area_mm2"] = smallest_area(out["csa_profile"]);
  out["straightening_deg"] = straightening_degrees(path_before, path_after, segment, out["csa_profile"]);

  out["stents"] = json::array();
  for (const StentHistory& h : d.stents) {
    const StentSpec& spec = scene.stents.at(h.device);
    const Segment own = span_of(scene, {h.device, h.branch, h.centre_s, 0});
    const double reference = reference_area(lumen, before.at(h.branch), own);
    out["stents"].push_back(
        {{"device", h.device},
         {"branch", h.branch},
         {"inflated_diameter_mm", h.inflated_diameter()},
         {"final_diameter_mm", h.final_diameter},
         {"minimal_stent_area_mm2", h.minimal_area},
         {"minimal_lumen_area_in_stent_mm2", lumen_area_in_stent(h, spec.length, d, lumen.triangles)},
         {"expansion_index", reference > 0 ? json(h.minimal_area / reference) : json(nullptr)},
         {"recoil_percent", 100 * (1 - h.final_diameter / h.inflated_diameter())},
         {"recoil_percent_of_maker", spec.recoil_percent},
         {"foreshortening_percent", 100 * (1 - h.final_length / spec.length)}});
  }
  for (const char* key : {"minimal_stent_area_mm2", "minimal_lumen_area_in_stent_mm2", "expansion_index"})
    out[key] = first_in_order(out["stents"], key, std::less<>());
  for (const char* key : {"recoil_percent", "foreshortening_percent"})
    out[key] = first_in_order(out["stents"], key, std::greater<>());
  const double gap = *std::max_element(d.malapposition.begin(), d.malapposition.end());
  out["maximal_malapposition_mm"] = gap;
  for (const std::string& warning : warnings_of_outcome(out["stents"], gap))
    out["warnings"].push_back(warning);
  if (const Crossings found = self_crossings(lumen.triangles, moved_triangles(lumen, d.points), d.points);
      found.pairs > 0)
    out["warnings"].push_back(crossing_warning(found));
  return out;
}

} // namespace vci
