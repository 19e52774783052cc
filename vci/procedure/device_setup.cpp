#include "vci/procedure/device_setup.hpp"
#include "vci/procedure/placement.hpp"
#include "vci/procedure/unfolding.hpp"

#include <algorithm>

namespace vci {

namespace {

constexpr double least_balloon_radius = 0.04; // mm: least starting radius of a balloon's ring inside a stent
// A ring of a balloon inside its stent starts with at most this share of the stent's smallest radius, less a clearance.
constexpr double stent_radius_share = 0.9;

/// The rings of a device at its place on the axis of the deformed lumen.
/// @param moved current lumen points, mm
DeviceLayout layout_of(const RunState& run, const Placement& p, RingGrid grid, const Vectors& moved) {
  const Path path = follow_wall(run.paths.at(p.branch), run.lumen, moved);
  std::vector<Frame> frames = path.frames(grid.ring_arc_lengths(p.centre_s));
  const BalloonSpec& balloon = run.scene.balloon(p.device);
  const BalloonChart chart(balloon.chart_pressure_bar, balloon.chart_diameter, balloon.crimped_diameter);
  return {std::move(grid), std::move(frames), 0.5 * chart.diameter_at(p.pressure_bar)};
}

/// For each body in the system, the vertices excluded from contact with a new device: those at a window through which
/// the device leaves a stent.
std::vector<ContactScope> contact_scopes(const RunState& run, const DeviceLayout& layout) {
  std::vector<ContactScope> scopes(run.system.bodies());
  for (const StentHistory& h : run.stents)
    scopes[h.stent.body] = exclude_side_exit(run.system, h.stent, layout);
  return scopes;
}

void add_contacts(RunState& run, int inner, std::vector<ContactScope> scopes) {
  for (std::size_t body = 0; body < scopes.size(); ++body)
    run.interactions.contacts.emplace_back(inner, static_cast<int>(body), run.scene.numerics.contact,
                                           std::move(scopes[body]), run.interactions.trees);
}

/// Adds a stent and its contacts to the system. Returns the radius (mm) of the stent's narrowest ring.
double place_stent(RunState& run, const Placement& p, const Vectors& moved) {
  const StentSpec& spec = *run.scene.stent(p.device);
  const DeviceLayout layout = layout_of(run, p, stent_grid(spec, run.scene.numerics.device_edge), moved);
  std::vector<ContactScope> scopes = contact_scopes(run, layout);
  const std::vector<double> radii = start_radii(run.system, layout, spec.crimped_diameter, scopes);
  Stent stent = add_stent(run.system, spec, p.device, layout.grid, layout.frames, radii);
  add_contacts(run, stent.body, std::move(scopes));
  run.stents.push_back({p.device, p.branch, p.centre_s, std::move(stent)});
  return *std::min_element(radii.begin(), radii.end());
}

/// The balloon of a placed device. Makers measure the chart of a delivery balloon with the stent on it, so the balloon
/// alone is softer.
BalloonSpec balloon_alone(const Scene& scene, const std::string& device) {
  BalloonSpec balloon = scene.balloon(device);
  if (const auto& stent = scene.stent(device))
    balloon.chart_pressure_bar =
        pressures_without_stent(*stent, std::move(balloon.chart_pressure_bar), balloon.chart_diameter);
  return balloon;
}

/// The layouts of a step's balloons, delivery balloons included. Two balloons are moved apart, to lie side by side.
std::vector<DeviceLayout> balloon_layouts(const RunState& run, const Step& step, const Vectors& moved) {
  std::vector<DeviceLayout> layouts;
  double widest = 0;
  for (const Placement& p : step.devices) {
    const BalloonSpec balloon = balloon_alone(run.scene, p.device);
    layouts.push_back(layout_of(run, p, balloon_grid(balloon, run.scene.numerics.device_edge), moved));
    widest = std::max(widest, balloon.crimped_diameter);
  }
  if (layouts.size() == 2)
    set_side_by_side(layouts[0], layouts[1], widest);
  return layouts;
}

void place_balloon(RunState& run, const BalloonSpec& spec, const DeviceLayout& layout, const std::vector<double>& radii,
                   std::vector<ContactScope> scopes) {
  const ContactSettings& contact = run.scene.numerics.contact;
  run.balloons.push_back(add_balloon(run.system, spec, layout.grid, layout.frames, radii));
  const Balloon& balloon = run.balloons.back();
  add_contacts(run, balloon.body, std::move(scopes));
  add_layer_contacts(run.interactions, run.system, balloon, spec, contact);
  for (std::size_t other = 0; other + 1 < run.balloons.size(); ++other)
    run.interactions.contacts.emplace_back(balloon.body, run.balloons[other].body, contact, ContactScope{false, {}, {}},
                                           run.interactions.trees);
}

} // namespace

void place_devices(RunState& run, const Step& step) {
  const Vectors moved = run.current_lumen();
  run.balloons.clear();
  const std::vector<DeviceLayout> layouts = balloon_layouts(run, step, moved);
  // Stents first: balloons are taken out at the end of the step, and only the last bodies can be taken out.
  std::vector<std::vector<ContactScope>> scopes;
  std::vector<std::vector<double>> radii;
  for (std::size_t k = 0; k < layouts.size(); ++k) {
    const Placement& p = step.devices[k];
    scopes.push_back(contact_scopes(run, layouts[k]));
    radii.push_back(start_radii(run.system, layouts[k], run.scene.balloon(p.device).crimped_diameter, scopes[k]));
    if (!run.scene.stent(p.device))
      continue;
    const double stent_radius = place_stent(run, p, moved);
    scopes[k].emplace_back(); // no exclusions: the whole balloon is inside its stent
    for (double& r : radii[k])
      r = std::max(least_balloon_radius, std::min(r, stent_radius_share * stent_radius - start_clearance));
  }
  for (std::size_t k = 0; k < layouts.size(); ++k)
    place_balloon(run, balloon_alone(run.scene, step.devices[k].device), layouts[k], radii[k], std::move(scopes[k]));
}

void remove_balloons(RunState& run) {
  while (!run.balloons.empty()) {
    run.interactions.remove_body(run.balloons.back().body);
    run.system.remove_last_body();
    run.balloons.pop_back();
  }
}

std::vector<ContactPoint> contacts_on_body(RunState& run, int outer, bool of_stents) {
  const Normals normals(area_vectors(run.system));
  std::vector<ContactPoint> points;
  for (SurfaceContact& contact : run.interactions.contacts)
    if (contact.outer() == outer && run.is_stent(contact.inner()) == of_stents)
      contact.detect(run.system, normals, points);
  return points;
}

void tie_stents(RunState& run) {
  const double stiffness = run.scene.numerics.tie_stiffness;
  if (stiffness > 0) // otherwise contact alone holds the stents
    for (const ContactPoint& p : contacts_on_body(run, 0, true))
      run.interactions.ties.push_back(make_tie(p, run.system.x, stiffness));
}

} // namespace vci
