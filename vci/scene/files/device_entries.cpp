#include "vci/scene/files/device_entries.hpp"
#include "common/error.hpp"
#include "vci/devices/balloon/balloon_chart.hpp"
#include "vci/scene/files/checked_json.hpp"

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace vci {

using nlohmann::json;

namespace {

// limits of a chart's diameters over the nominal diameter
constexpr double least_chart_ratio = 0.5, largest_chart_ratio = 1.5;
constexpr double highest_pressure = 60; // largest pressure accepted in a chart, bar
constexpr double overhang = 1;          // mm by which a stent may be longer than its balloon's cylinder
// largest difference between the nominal diameters of stent and balloon, over the stent's
constexpr double mounting_tolerance = 0.25;
// Largest relative difference between the nominal diameter and the chart's diameter at nominal pressure. Charts are
// rounded to 0.01 or 0.02 mm and linear between their points.
constexpr double nominal_tolerance = 0.01;

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
  o.refuse_unknown_keys();
  return f;
}

std::string text_of_pair(double one, const char* between, double other, const char* unit = " mm") {
  std::ostringstream text;
  text << one << between << other << unit;
  return text.str();
}

/// Refuses impossible charts: pressures out of range, or diameters far from the nominal diameter.
void check_chart(const BalloonSpec& b, const CheckedObject& chart) {
  for (const double p : b.chart_pressure_bar)
    if (!(p > 0 && p <= highest_pressure))
      throw common::InputError("a pressure that no balloon is made for", chart.path("pressure_bar"),
                               text_of_pair(p, ", above 0 and at most ", highest_pressure, " bar"),
                               "give the maker's chart, in bar, without an entry at 0 bar");
  for (const double d : b.chart_diameter)
    if (!(d >= least_chart_ratio * b.nominal_diameter && d <= largest_chart_ratio * b.nominal_diameter))
      throw common::InputError("a chart that leaves the nominal diameter far behind", chart.path("diameter_mm"),
                               text_of_pair(d, " mm, nominal ", b.nominal_diameter),
                               "give the maker's chart, within 50 to 150 % of nominal_diameter_mm");
}

void check_crimped(double crimped, double nominal, const CheckedObject& o) {
  if (crimped >= nominal)
    throw common::InputError("a device that is as wide crimped as it is opened", o.path("crimped_diameter_mm"),
                             text_of_pair(crimped, " mm, nominal ", nominal), "give the profile on the way in");
}

} // namespace

BalloonSpec read_balloon(const json& entry, const std::string& where) {
  CheckedObject o(entry, where);
  o.ignore("kind");
  BalloonSpec b{};
  b.nominal_diameter = o.number("nominal_diameter_mm", 0.5, 10);
  b.length = o.number("length_mm", 2, 100);
  b.shoulder = o.number("shoulder_mm", 0.3, 10, b.shoulder);
  b.crimped_diameter = o.number("crimped_diameter_mm", 0.2, 3);
  const double nominal_pressure = o.has("nominal_pressure_bar") ? o.number("nominal_pressure_bar", 0.1, 40) : 0;
  b.rated_burst_pressure_bar = o.number("rated_burst_pressure_bar", 0.1, 60);
  CheckedObject chart(o.child("chart", true), o.path("chart"));
  b.chart_pressure_bar = chart.numbers("pressure_bar");
  b.chart_diameter = chart.numbers("diameter_mm");
  check_crimped(b.crimped_diameter, b.nominal_diameter, o);
  check_chart(b, chart);
  chart.refuse_unknown_keys();
  if (o.has("folding"))
    b.folding = read_folding(o.child("folding", true), o.path("folding"));
  try {
    const BalloonChart chart_in_bar(b.chart_pressure_bar, b.chart_diameter, b.crimped_diameter);
    const double charted = nominal_pressure > 0 ? chart_in_bar.diameter_at(nominal_pressure) : b.nominal_diameter;
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
  o.refuse_unknown_keys();
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
  check_crimped(s.crimped_diameter, s.nominal_diameter, o);
  if (s.crimped_diameter <= 2 * s.strut_thickness)
    throw common::InputError("struts that leave the crimped stent no lumen", o.path("strut_thickness_mm"),
                             text_of_pair(s.strut_thickness, " mm, crimped to ", s.crimped_diameter),
                             "give the struts' radial thickness and the stent's crossing profile");
  if (s.links > s.crowns)
    throw common::InputError("more links than crowns that they could join", o.path("links"),
                             std::to_string(s.links) + " links, " + std::to_string(s.crowns) + " crowns",
                             "give connectors between two neighbouring rings, at most one for each crown");
  s.radial_strength_mpa = o.number("radial_strength_mpa", 0.01, 2, s.radial_strength_mpa);
  if (entry.contains("hoop_stiffness_n_per_mm") && entry["hoop_stiffness_n_per_mm"].is_null())
    o.ignore("hoop_stiffness_n_per_mm");
  else if (o.has("hoop_stiffness_n_per_mm"))
    s.stated_hoop_stiffness = o.number("hoop_stiffness_n_per_mm", 0.1, 1e3);
  s.axial_stiffness = o.number("axial_stiffness_n_per_mm", 1e-3, 1e3, s.axial_stiffness);
  s.bending_stiffness = o.number("bending_stiffness_n_mm2", 1e-3, 1e4, s.bending_stiffness);
  s.recoil_percent = o.number("recoil_percent", 0.1, 20, s.recoil_percent);
  o.refuse_unknown_keys();
  return s;
}

void check_stent_on_balloon(const StentSpec& s, const BalloonSpec& b, const std::string& where) {
  const std::string at = where + ".balloon";
  if (s.length > b.length + overhang)
    throw common::InputError("a stent longer than the balloon it is crimped on", at,
                             text_of_pair(s.length, " mm on ", b.length),
                             "name a balloon whose length_mm, without its shoulders, is the stent's");
  if (std::abs(b.nominal_diameter / s.nominal_diameter - 1) > mounting_tolerance)
    throw common::InputError("a stent on a balloon of quite another diameter", at,
                             text_of_pair(s.nominal_diameter, " mm on ", b.nominal_diameter),
                             "name a balloon of the stent's nominal_diameter_mm");
  if (s.crimped_diameter < b.crimped_diameter)
    throw common::InputError("a stent crimped thinner than the balloon inside it", at,
                             text_of_pair(s.crimped_diameter, " mm on ", b.crimped_diameter),
                             "give the crossing profiles of the stent and of its balloon");
}

} // namespace vci
