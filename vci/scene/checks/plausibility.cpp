#include "vci/scene/checks/plausibility.hpp"
#include "common/error.hpp"
#include "vci/devices/balloon/balloon_chart.hpp"

#include <algorithm>

namespace vci {

namespace {
using common::text;

// mm: a balloon reaches into a stent if their axes come nearer to each other than this
constexpr double inside_stent_distance = 0.5;

struct Span {
  double start, end; ///< arc lengths, mm
};

Span span_of(const Placement& p, double length) {
  return {p.centre_s - 0.5 * length, p.centre_s + 0.5 * length};
}

const Path& find_branch(const std::string& name, const std::string& where, const std::map<std::string, Path>& paths) {
  if (!paths.contains(name))
    throw common::InputError("a branch that the centreline does not have", where, name,
                             "use a branch_name of the centreline");
  return paths.at(name);
}

void check_within_branch(const Path& path, const Span& span, const std::string& what, const std::string& where,
                         const std::string& remedy) {
  constexpr double rounding = 1e-6; // mm
  if (span.start < path.start() - rounding || span.end > path.end() + rounding)
    throw common::InputError(what, where, text("from ", span.start, " to ", span.end, " mm"),
                             text(remedy, " within ", path.start(), " to ", path.end(), " mm"));
}

/// Whether a balloon reaches into a stent: somewhere along both, their axes are nearer to each other than
/// `inside_stent_distance`.
bool reaches_into(const Placement& balloon, double balloon_length, const Placement& stent, double stent_length,
                  const std::map<std::string, Path>& paths) {
  constexpr double step = 0.25; // mm between the places compared
  const Path &balloon_axis = paths.at(balloon.branch), &stent_axis = paths.at(stent.branch);
  const Span inner = span_of(balloon, balloon_length), outer = span_of(stent, stent_length);
  for (double s = inner.start; s <= inner.end; s += step)
    for (double t = outer.start; t <= outer.end; t += step)
      if ((balloon_axis.at(s) - stent_axis.at(t)).norm() < inside_stent_distance)
        return true;
  return false;
}

double free_diameter(const BalloonSpec& b, double pressure_bar) {
  return BalloonChart(b.chart_pressure_bar, b.chart_diameter, b.crimped_diameter).diameter_at(pressure_bar);
}

} // namespace

std::string device_location(const Scene& scene, std::size_t step, std::size_t device) {
  const Step& s = scene.procedure[step];
  return text(scene.file.string(), ": scene.procedure[", step, "].devices[", device, "] (step ", s.name, ", ",
              s.devices[device].device, ")");
}

void check_placements(const Scene& scene, const std::map<std::string, Path>& paths) {
  std::vector<Placement> stents;
  for (std::size_t step = 0; step < scene.procedure.size(); ++step)
    for (std::size_t device = 0; device < scene.procedure[step].devices.size(); ++device) {
      const Placement& p = scene.procedure[step].devices[device];
      const std::string where = device_location(scene, step, device);
      const Path& path = find_branch(p.branch, where, paths);
      const BalloonSpec& balloon = scene.balloon(p.device);
      check_within_branch(path, span_of(p, scene.opened_length(p.device)),
                          "a device reaches past the end of its branch", where,
                          "choose centre_s_mm and length_mm so that it lies");
      if (scene.stent(p.device))
        stents.push_back(p);
      const double diameter = free_diameter(balloon, p.pressure_bar);
      for (const Placement& s : stents) {
        const StentSpec& stent = scene.stents.at(s.device);
        if (diameter > stent.maximal_diameter && reaches_into(p, balloon.length, s, stent.length, paths))
          throw common::InputError("a balloon that opens a stent beyond its maximal diameter", where,
                                   text(diameter, " mm by its chart; ", s.device, ": at most ", stent.maximal_diameter),
                                   "choose a smaller balloon, less pressure or another stent");
      }
    }
  if (scene.segment) {
    const Segment& s = *scene.segment;
    const std::string where = scene.file.string() + ": scene.segment";
    check_within_branch(find_branch(s.branch, where, paths), {s.s_start, s.s_end}, "a segment reaches past its branch",
                        where, "choose s_start_mm and s_end_mm");
  }
}

} // namespace vci
