#include "vci/scene.hpp"
#include "common/error.hpp"
#include "vci/balloon_chart.hpp"
#include "vci/checked_json.hpp"
#include "vci/reading.hpp"

#include <algorithm>
#include <fstream>
#include <limits>
#include <set>

namespace vci {

using nlohmann::json;

namespace {

const std::set<std::string> actions{"predilatation",       "stent",  "postdilatation", "proximal_optimisation",
                                    "side_branch_opening", "kissing"};

PlaqueSpec read_plaque(CheckedObject& parent, const std::string& type, const PlaqueSpec& defaults, json& used) {
  CheckedObject o(parent.child(type, false), parent.path(type));
  PlaqueSpec p = defaults;
  p.youngs_modulus = o.number("youngs_modulus_mpa", 1e-3, 1e5, p.youngs_modulus);
  const json raw = parent.child(type, false);
  const bool never = raw.contains("yield_strain") ? raw["yield_strain"].is_null() : std::isinf(p.yield_strain);
  if (never) {
    o.ignore("yield_strain");
    o.used["yield_strain"] = nullptr;
    p.yield_strain = std::numeric_limits<double>::infinity();
  } else {
    p.yield_strain = o.number("yield_strain", 1e-3, 2.0, std::isinf(p.yield_strain) ? 0.12 : p.yield_strain);
  }
  p.hardening = o.number("hardening", 0, 1, p.hardening);
  o.finish();
  used[type] = o.used;
  return p;
}

WallSpec read_wall(const json& entry, const std::string& where, json& used) {
  CheckedObject o(entry, where);
  WallSpec w;
  w.model = o.text("model", w.model);
  if (w.model != "membrane" && w.model != "mass-spring")
    throw common::InputError("an unknown wall model", o.path("model"), w.model, "use membrane or mass-spring");
  const std::string mapping = o.text("spring_mapping", "lame");
  if (mapping != "lame" && mapping != "van_gelder")
    throw common::InputError("an unknown spring mapping", o.path("spring_mapping"), mapping, "use lame or van_gelder");
  w.spring_mapping = mapping == "lame" ? SpringMapping::lame : SpringMapping::van_gelder;
  w.youngs_modulus = o.number("youngs_modulus_mpa", 1e-3, 1e3, w.youngs_modulus);
  w.poisson_ratio = o.number("poisson_ratio", 0, 0.499, w.poisson_ratio);
  w.intima_thickness = o.number("intima_thickness_mm", 0.01, 2, w.intima_thickness);
  w.media_thickness = o.number("media_thickness_mm", 0.01, 2, w.media_thickness);
  w.stiffening = o.number("stiffening", 0, 100, w.stiffening);
  w.tissue_modulus = o.number("tissue_modulus_mpa", 0, 10, w.tissue_modulus);
  w.tangential_stiffness = o.number("tangential_stiffness_mpa_per_mm", 0, 10, w.tangential_stiffness);
  w.density = o.number("density_g_per_mm3", 1e-5, 0.1, w.density);
  w.hinge_yield = o.number("hinge_yield_rad", 1e-3, 10, w.hinge_yield);
  CheckedObject p(o.child("plaque", false), o.path("plaque"));
  const double never = std::numeric_limits<double>::infinity();
  json plaque;
  w.plaque[0] = {1, never, 0};
  w.plaque[1] = read_plaque(p, "fibrous", {2.0, 0.12, 0.08}, plaque);
  w.plaque[2] = read_plaque(p, "lipid", {0.5, 0.10, 0.05}, plaque);
  w.plaque[3] = read_plaque(p, "calcified", {30.0, never, 0.0}, plaque);
  p.finish();
  o.finish();
  used = o.used;
  used["plaque"] = plaque;
  return w;
}

Numerics read_numerics(const json& entry, const std::string& where, json& used) {
  CheckedObject o(entry, where);
  Numerics n;
  IntegratorSettings& i = n.integrator;
  ContactSettings& c = n.contact;
  const auto choice = [&](const char* key, const char* usual, const char* other) {
    const std::string text = o.text(key, usual);
    if (text != usual && text != other)
      throw common::InputError("an unknown choice", o.path(key), text, std::string("use ") + usual + " or " + other);
    return text == other;
  };
  i.residual_tolerance = o.number("residual_tolerance", 1e-8, 0.1, i.residual_tolerance);
  i.displacement_per_step = o.number("displacement_per_step_mm", 1e-3, 1, i.displacement_per_step);
  i.initial_step = o.number("initial_step_ms", 1e-4, 1e4, i.initial_step);
  i.maximal_step = o.number("maximal_step_ms", 1e-3, 1e6, i.maximal_step);
  i.maximal_steps = o.integer("maximal_steps_per_stage", 1, 1000000, i.maximal_steps);
  i.stalled_steps = o.integer("stalled_steps_per_stage", 1, 1000000, i.stalled_steps);
  i.pcg.tolerance = o.number("pcg_tolerance", 1e-12, 0.5, i.pcg.tolerance);
  i.pcg.maximal_iterations = o.integer("pcg_maximal_iterations", 1, 100000, i.pcg.maximal_iterations);
  i.pcg.patch_size = o.integer("pcg_patch_vertices", 0, 10000, i.pcg.patch_size);
  i.pcg.single_precision = !choice("pcg_precision", "single", "double");
  c.stiffness = o.number("contact_stiffness_mpa_per_mm", 1, 1e5, c.stiffness);
  c.distance = o.number("contact_distance_mm", 0, 0.2, c.distance);
  c.ramp = o.number("contact_ramp_mm", 1e-4, 0.2, c.ramp);
  c.skin = o.number("contact_skin_mm", 1e-3, 0.4, c.skin);
  c.smooth = !choice("contact_surface", "smooth", "facets");
  c.friction = o.number("friction_coefficient", 0, 1, c.friction);
  c.friction_stiffness = o.number("friction_stiffness_mpa_per_mm", 1e-3, 1e4, c.friction_stiffness);
  i.textbook = choice("integration", "adaptive", "textbook");
  i.fixed_step = o.number("fixed_step_ms", 1e-5, 10, i.fixed_step);
  i.velocity_stop = o.number("velocity_stop_mm_per_ms", 1e-9, 10, i.velocity_stop);
  c.time_averaged = choice("contact_law", "one-sided", "time-averaged");
  if (c.time_averaged && !i.textbook)
    throw common::InputError("a contact law that follows velocities, without any", o.path("contact_law"),
                             "time-averaged", "set integration to textbook, or leave the one-sided law");
  n.tie_stiffness = o.number("tie_stiffness_mpa_per_mm", 0, 1e5, n.tie_stiffness);
  i.damping = o.number("damping_mpa_ms_per_mm", 0, 1e4, i.damping);
  i.stiffness_damping = o.number("stiffness_damping_ms", 0, 1e4, i.stiffness_damping);
  n.region_margin = o.number("region_margin_mm", 1, 1000, n.region_margin);
  n.device_edge = o.number("device_edge_mm", 0.1, 1.5, n.device_edge);
  n.contact_pressure_fraction = o.number("contact_pressure_fraction", 0.01, 1, n.contact_pressure_fraction);
  o.finish();
  used = o.used;
  return n;
}

Step read_step(const json& entry, const std::string& where, const Scene& scene) {
  CheckedObject o(entry, where);
  Step step{o.text("name"), o.text("action"), {}};
  if (!actions.contains(step.action))
    throw common::InputError(
        "an unknown action", o.path("action"), step.action,
        "use predilatation, stent, postdilatation, proximal_optimisation, side_branch_opening or kissing");
  const json list = o.list("devices");
  for (std::size_t k = 0; k < list.size(); ++k) {
    CheckedObject d(list[k], where + ".devices[" + std::to_string(k) + "]");
    Placement p{d.text("device"), d.text("branch", "main"), d.number("centre_s_mm", -1e4, 1e4), 0};
    const bool stent = scene.stents.contains(p.device), balloon = scene.balloons.contains(p.device);
    if (!stent && !balloon)
      throw common::InputError("a device that the scene does not define", d.path("device"), p.device,
                               "add it under devices or correct the name");
    const BalloonSpec& b = scene.balloons.at(stent ? scene.stents.at(p.device).balloon : p.device);
    p.pressure_bar = d.number("pressure_bar", 0.1, 40);
    const double ceiling = 1.5 * b.rated_burst_pressure_bar;
    if (p.pressure_bar > ceiling)
      throw common::InputError("a pressure far beyond the balloon's rated burst pressure", d.path("pressure_bar"),
                               std::to_string(p.pressure_bar), "stay below " + std::to_string(ceiling) + " bar");
    d.finish();
    step.devices.push_back(p);
  }
  if (step.devices.size() > 1 && step.action != "kissing")
    throw common::InputError("several devices in one step", o.path("devices"), std::to_string(step.devices.size()),
                             "only kissing inflates several balloons at once; use one step per device");
  const bool with_stent = std::any_of(step.devices.begin(), step.devices.end(),
                                      [&](const Placement& p) { return scene.stents.contains(p.device); });
  if (step.action == "kissing" && (step.devices.size() != 2 || with_stent))
    throw common::InputError("kissing inflates two balloons side by side", o.path("devices"),
                             std::to_string(step.devices.size()) + (with_stent ? " devices, with a stent" : " devices"),
                             "name two balloons; place stents in steps of their own");
  o.finish();
  return step;
}

} // namespace

namespace {

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
  o.number("nominal_pressure_bar", 0.1, 40, 8.0);
  b.rated_burst_pressure_bar = o.number("rated_burst_pressure_bar", 0.1, 60);
  CheckedObject chart(o.child("chart", true), o.path("chart"));
  b.chart_pressure_bar = chart.numbers("pressure_bar");
  b.chart_diameter = chart.numbers("diameter_mm");
  chart.finish();
  if (o.has("folding"))
    b.folding = read_folding(o.child("folding", true), o.path("folding"));
  try {
    BalloonChart(b.chart_pressure_bar, b.chart_diameter, b.crimped_diameter);
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

namespace {

Scene scene_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream)
    throw common::InputError("the scene cannot be opened", file.string(), "no readable file", "check the path");
  json document;
  try {
    document = json::parse(stream);
  } catch (const json::parse_error& e) {
    throw common::InputError("the scene is not JSON", file.string(), e.what(), "correct the text at that byte");
  }
  const std::string where = file.string() + ": scene";
  CheckedObject o(document, where);
  const std::string schema = o.text("schema");
  if (schema != "vci-scene-1")
    throw common::InputError("not a scene of this version", o.path("schema"), schema, "write \"vci-scene-1\"");
  Scene scene;
  scene.case_name = o.text("case", "");
  scene.lumen = file.parent_path() / o.text("lumen");
  scene.centreline = file.parent_path() / o.text("centreline");
  CheckedObject patient(o.child("patient", true), o.path("patient"));
  scene.map_pa = patient.number("map_pa", 1000, 40000);
  patient.finish();
  if (o.has("segment")) {
    CheckedObject s(o.child("segment", true), o.path("segment"));
    scene.segment = Segment{s.text("branch", "main"), s.number("s_start_mm", 0, 1e4), s.number("s_end_mm", 0, 1e4)};
    s.finish();
    if (scene.segment->s_end <= scene.segment->s_start)
      throw common::InputError("the segment ends before it starts", o.path("segment"), o.child("segment", true).dump(),
                               "give s_start_mm < s_end_mm");
  }
  json wall, numerics;
  scene.wall = read_wall(o.child("wall", false), o.path("wall"), wall);
  scene.numerics = read_numerics(o.child("numerics", false), o.path("numerics"), numerics);
  scene.settings = {{"wall", wall}, {"numerics", numerics}, {"map_pa", scene.map_pa}};
  const json devices = o.child("devices", true);
  for (const auto& [name, entry] : devices.items()) {
    const std::string at = o.path("devices") + "." + name, kind = entry.value("kind", "missing");
    if (kind == "balloon")
      scene.balloons[name] = read_balloon(entry, at);
    else if (kind == "stent")
      scene.stents[name] = read_stent(entry, at);
    else
      throw common::InputError("an unknown kind of device", at + ".kind", kind, "use balloon or stent");
  }
  for (const auto& [name, stent] : scene.stents)
    if (!scene.balloons.contains(stent.balloon))
      throw common::InputError("a stent without its delivery balloon", o.path("devices") + "." + name + ".balloon",
                               stent.balloon, "add that balloon under devices");
  const json steps = o.list("procedure");
  for (std::size_t k = 0; k < steps.size(); ++k)
    scene.procedure.push_back(read_step(steps[k], o.path("procedure") + "[" + std::to_string(k) + "]", scene));
  o.finish();
  return scene;
}

} // namespace

Scene read_scene(const std::filesystem::path& file) {
  return reading(file, [&] { return scene_of(file); });
}

} // namespace vci
