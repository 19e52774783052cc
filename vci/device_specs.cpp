#include "common/error.hpp"
#include "vci/balloon_chart.hpp"
#include "vci/checked_json.hpp"
#include "vci/scene.hpp"

#include <cmath>
#include <stdexcept>

namespace vci {

using nlohmann::json;

namespace {

constexpr double nominal_tolerance = 0.01; // charts round to 0.01 or 0.02 mm, and are straight between their points

FoldingSpec read_folding(const json& entry, const std::string& where) {
  CheckedObject o(entry, where);
  FoldingSpec f;
  f.wings = o.integer("wings", 2, 6, f.wings);
  f.shaft_diameter = o.number("shaft_diameter_mm", 0.2, 2, f.shaft_diameter);
  f.membrane_thickness = o.number("membrane_thickness_mm", 0.01, 0.1, f.membrane_thickness);
  const std::string wrap = o.text("wrap", "counterclockwise");
  if (wrap != "counterclockwise" && wrap != "clockwise")
    throw common::InputError("an unknown sense", o.path("wrap"), wrap, "use counterclockwise or clockwise");
  f.clockwise = wrap == "clockwise";
  o.finish();
  return f;
}

} // namespace

BalloonSpec read_balloon(const json& entry, const std::string& where) {
  CheckedObject o(entry, where);
  o.ignore("kind");
  BalloonSpec b{};
  b.nominal_diameter = o.number("nominal_diameter_mm", 0.5, 10);
  b.length = o.number("length_mm", 2, 100);
  b.shoulder = o.number("shoulder_mm", 0.3, 10, 1.2);
  b.crimped_diameter = o.number("crimped_diameter_mm", 0.2, 3);
  const double nominal_pressure = o.has("nominal_pressure_bar") ? o.number("nominal_pressure_bar", 0.1, 40) : 0;
  b.rated_burst_pressure_bar = o.number("rated_burst_pressure_bar", 0.1, 60);
  CheckedObject chart(o.child("chart", true), o.path("chart"));
  b.chart_pressure_bar = chart.numbers("pressure_bar");
  b.chart_diameter = chart.numbers("diameter_mm");
  chart.finish();
  if (o.has("folding"))
    b.folding = read_folding(o.child("folding", true), o.path("folding"));
  try {
    const BalloonChart by_bar(b.chart_pressure_bar, b.chart_diameter, b.crimped_diameter);
    const double charted = nominal_pressure > 0 ? by_bar.diameter_at(nominal_pressure) : b.nominal_diameter;
    if (std::abs(charted / b.nominal_diameter - 1) > nominal_tolerance)
      throw common::InputError("the chart contradicts the nominal diameter", o.path("nominal_pressure_bar"),
                               std::to_string(nominal_pressure) + " bar: " + std::to_string(charted) +
                                   " mm by the chart, nominal_diameter_mm " + std::to_string(b.nominal_diameter),
                               "give the pressure at which the chart has the nominal diameter, within 1 %");
    if (b.folding)
      BalloonChart::of_unfolded(b.chart_pressure_bar, b.chart_diameter);
  } catch (const std::invalid_argument& e) {
    throw common::InputError(e.what(), o.path("chart"), entry.at("chart").dump().substr(0, 80),
                             "give the maker's chart, rising in both columns");
  }
  o.finish();
  return b;
}

StentSpec read_stent(const json& entry, const std::string& where) {
  CheckedObject o(entry, where);
  o.ignore("kind");
  StentSpec s{};
  s.nominal_diameter = o.number("nominal_diameter_mm", 0.5, 10);
  s.length = o.number("length_mm", 2, 100);
  s.crimped_diameter = o.number("crimped_diameter_mm", 0.3, 3);
  s.maximal_diameter = o.number("maximal_diameter_mm", s.nominal_diameter, 12);
  s.strut_thickness = o.number("strut_thickness_mm", 0.01, 0.5);
  s.crowns = o.integer("crowns", 2, 30);
  s.links = o.integer("links", 1, 30);
  s.balloon = o.text("balloon");
  s.yield_strain = o.number("yield_strain", 1e-3, 0.3, 0.03);
  s.radial_strength_mpa = o.number("radial_strength_mpa", 0.01, 2, 0.22);
  // by Laplace: the expanded ring yields under just the outside pressure that its maker states
  const double by_strength = 0.5 * s.radial_strength_mpa * s.nominal_diameter / s.yield_strain;
  if (entry.contains("hoop_stiffness_n_per_mm") && entry["hoop_stiffness_n_per_mm"].is_null())
    o.ignore("hoop_stiffness_n_per_mm");
  else
    s.hoop_stiffness = o.number("hoop_stiffness_n_per_mm", 0.1, 1e3, by_strength);
  if (s.hoop_stiffness == 0)
    s.hoop_stiffness = by_strength;
  s.axial_stiffness = o.number("axial_stiffness_n_per_mm", 1e-3, 1e3, 0.5);
  s.bending_stiffness = o.number("bending_stiffness_n_mm2", 1e-3, 1e4, 5.5);
  s.recoil_percent = o.number("recoil_percent", 0, 20, 4.0);
  o.finish();
  return s;
}

} // namespace vci
