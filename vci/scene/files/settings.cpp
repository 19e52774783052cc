#include "vci/scene/files/settings.hpp"
#include "common/error.hpp"
#include "vci/scene/files/checked_json.hpp"

#include <limits>

namespace vci {

using nlohmann::json;

namespace {

void read_plaque(CheckedObject& parent, const std::string& type, PlaqueSpec& p) {
  CheckedObject o(parent.child(type, false), parent.path(type));
  p.youngs_modulus = o.number("youngs_modulus_mpa", 1e-3, 1e5, p.youngs_modulus);
  p.yield_strain = o.number_or_infinity("yield_strain", 1e-3, 1, p.yield_strain);
  p.hardening = o.number("hardening", 0, 1, p.hardening);
  o.refuse_unknown_keys();
  parent.values_read[type] = o.values_read;
  parent.key_schemas[type] = o.key_schemas;
}

/// Refuses changed settings that only the other integration uses, since they would be ignored silently.
void refuse_unused(const CheckedObject& o, const Numerics& n) {
  struct Setting {
    const char* key;
    double value, default_value;
  };
  const IntegratorSettings &i = n.integrator, defaults;
  const std::vector<Setting> of_textbook{
      {"fixed_step_ms", i.fixed_step, defaults.fixed_step},
      {"velocity_stop_mm_per_ms", i.velocity_stop, defaults.velocity_stop},
  };
  const std::vector<Setting> of_adaptive{
      {"residual_tolerance", i.residual_tolerance, defaults.residual_tolerance},
      {"maximal_penetration_mm", i.maximal_penetration, defaults.maximal_penetration},
      {"displacement_per_step_mm", i.displacement_per_step, defaults.displacement_per_step},
      {"initial_step_ms", i.initial_step, defaults.initial_step},
      {"maximal_step_ms", i.maximal_step, defaults.maximal_step},
      {"stalled_steps_per_stage", static_cast<double>(i.stalled_steps), static_cast<double>(defaults.stalled_steps)},
      {"pcg_patch_vertices", static_cast<double>(i.pcg.patch_size), static_cast<double>(defaults.pcg.patch_size)},
      {"damping_mpa_ms_per_mm", i.damping, defaults.damping},
      {"stiffness_damping_ms", i.stiffness_damping, defaults.stiffness_damping},
      {"region_margin_mm", n.region_margin, Numerics{}.region_margin},
  };
  for (const Setting& s : i.textbook ? of_adaptive : of_textbook)
    if (s.value != s.default_value)
      throw common::InputError(i.textbook ? "a setting of adaptive integration, in textbook integration"
                                          : "a setting of textbook integration, without it",
                               o.path(s.key), std::to_string(s.value),
                               i.textbook ? "set integration to adaptive, or leave it out"
                                          : "set integration to textbook, or leave it out");
}

} // namespace

WallSpec read_wall(CheckedObject& o) {
  WallSpec w;
  w.model = o.choice<WallModel>("model", {{"membrane", WallModel::membrane}, {"mass-spring", WallModel::mass_spring}},
                                w.model);
  w.spring_mapping = o.choice<SpringMapping>(
      "spring_mapping", {{"lame", SpringMapping::lame}, {"van_gelder", SpringMapping::van_gelder}}, w.spring_mapping);
  if (w.model != WallModel::mass_spring && w.spring_mapping != WallSpec{}.spring_mapping)
    throw common::InputError("a mapping to springs, without any", o.path("spring_mapping"),
                             o.values_read.at("spring_mapping").get<std::string>(),
                             "set model to mass-spring, or leave it out");
  w.youngs_modulus = o.number("youngs_modulus_mpa", 1e-3, 100, w.youngs_modulus); // a larger value is likely in kPa
  w.poisson_ratio = o.number("poisson_ratio", 0, 0.499, w.poisson_ratio);
  w.thickness = o.number("thickness_mm", 0.02, 4, w.thickness);
  w.stiffening = o.number("stiffening", 0, 100, w.stiffening);
  w.tissue_modulus = o.number("tissue_modulus_mpa", 0, 10, w.tissue_modulus);
  w.tangential_stiffness = o.number("tangential_stiffness_mpa_per_mm", 0, 10, w.tangential_stiffness);
  w.density = o.number("density_g_per_mm3", 1e-5, 0.1, w.density);
  w.hinge_yield = o.number("hinge_yield_rad", 1e-3, 3, w.hinge_yield); // triangles fold by less than a half turn
  CheckedObject plaque(o.child("plaque", false), o.path("plaque"));
  read_plaque(plaque, "fibrous", w.plaque[1]);
  read_plaque(plaque, "lipid", w.plaque[2]);
  read_plaque(plaque, "calcified", w.plaque[3]);
  plaque.refuse_unknown_keys();
  o.values_read["plaque"] = plaque.values_read;
  o.key_schemas["plaque"] = plaque.key_schemas;
  o.refuse_unknown_keys();
  return w;
}

Numerics read_numerics(CheckedObject& o) {
  Numerics n;
  IntegratorSettings& i = n.integrator;
  ContactSettings& c = n.contact;
  i.residual_tolerance = o.number("residual_tolerance", 1e-8, 0.1, i.residual_tolerance);
  i.maximal_penetration = o.number("maximal_penetration_mm", 0.03, 1, i.maximal_penetration);
  i.displacement_per_step = o.number("displacement_per_step_mm", 1e-3, 1, i.displacement_per_step);
  i.initial_step = o.number("initial_step_ms", 1e-4, 1e4, i.initial_step);
  i.maximal_step = o.number("maximal_step_ms", 1e-3, 1e4, i.maximal_step);
  i.maximal_steps = o.integer("maximal_steps_per_stage", 1, 1000000, i.maximal_steps);
  i.stalled_steps = o.integer("stalled_steps_per_stage", 1, 1000000, i.stalled_steps);
  i.pcg.tolerance = o.number("pcg_tolerance", 1e-12, 0.5, i.pcg.tolerance);
  i.pcg.maximal_iterations = o.integer("pcg_maximal_iterations", 1, 100000, i.pcg.maximal_iterations);
  i.pcg.patch_size = o.integer("pcg_patch_vertices", 0, 10000, i.pcg.patch_size);
  i.pcg.single_precision = o.choice<bool>("pcg_precision", {{"single", true}, {"double", false}}, true);
  c.stiffness = o.number("contact_stiffness_mpa_per_mm", 1, 1e4, c.stiffness);
  c.distance = o.number("contact_distance_mm", 0, 0.2, c.distance);
  c.ramp = o.number("contact_ramp_mm", 1e-4, 0.2, c.ramp);
  c.skin = o.number("contact_skin_mm", 1e-3, 0.4, c.skin);
  c.smooth = o.choice<bool>("contact_surface", {{"smooth", true}, {"facets", false}}, true);
  c.friction = o.number("friction_coefficient", 0, 1, c.friction);
  c.friction_stiffness = o.number("friction_stiffness_mpa_per_mm", 1e-3, 1e4, c.friction_stiffness);
  i.textbook = o.choice<bool>("integration", {{"adaptive", false}, {"textbook", true}}, false);
  i.fixed_step = o.number("fixed_step_ms", 1e-5, 10, i.fixed_step);
  i.velocity_stop = o.number("velocity_stop_mm_per_ms", 1e-9, 10, i.velocity_stop);
  c.time_averaged = o.choice<bool>("contact_law", {{"one-sided", false}, {"time-averaged", true}}, false);
  if (c.time_averaged && !i.textbook)
    throw common::InputError("a contact law that follows velocities, without any", o.path("contact_law"),
                             "time-averaged", "set integration to textbook, or leave the one-sided law");
  n.tie_stiffness = o.number("tie_stiffness_mpa_per_mm", 0, 1e4, n.tie_stiffness);
  i.damping = o.number("damping_mpa_ms_per_mm", 0, 1e4, i.damping);
  i.stiffness_damping = o.number("stiffness_damping_ms", 0, 1e4, i.stiffness_damping);
  n.region_margin = o.number("region_margin_mm", 1, 1000, n.region_margin);
  n.device_edge = o.number("device_edge_mm", 0.1, 1.5, n.device_edge);
  n.contact_pressure_fraction = o.number("contact_pressure_fraction", 0.01, 1, n.contact_pressure_fraction);
  refuse_unused(o, n);
  if (i.initial_step > i.maximal_step)
    throw common::InputError("a first step longer than any may be", o.path("initial_step_ms"),
                             std::to_string(i.initial_step) + " ms, maximal_step_ms " + std::to_string(i.maximal_step),
                             "lower it, or raise maximal_step_ms");
  o.refuse_unknown_keys();
  return n;
}

json settings_table() {
  CheckedObject wall(json::object(), "wall"), numerics(json::object(), "numerics");
  read_wall(wall);
  read_numerics(numerics);
  return {{"wall", wall.key_schemas}, {"numerics", numerics.key_schemas}};
}

} // namespace vci
