#include "vci/bench/crush.hpp"
#include "common/error.hpp"
#include "vci/bench/crimper.hpp"
#include "vci/devices/balloon/balloon.hpp"
#include "vci/devices/stent/stent.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace vci {

namespace {

// The balloon is first inflated to this share of its nominal pressure, at which the crimped stent already yields.
constexpr double opening_pressure_share = 0.75;
// Outside pressure during free recoil, as a share of the radial strength. Without this pressure no force would be
// applied to the free stent, and the residual is relative to the applied forces.
constexpr double free_pressure_share = 0.01;
constexpr double closing_step = 0.005;     // share of the free stent's radius by which the crimper closes at a time
constexpr double crimper_stiffness = 60.0; // pressure per depth, MPa/mm
constexpr double anchor_stiffness = 1e-5;  // N/mm per vertex: keeps the free stent from drifting off
constexpr double clearance = 0.03;         // mm between the crimped stent and its balloon
// losses of diameter, in % of the free stent's, at which the pressure is reported
constexpr double reported_losses_percent[] = {1, 2, 5, 10};

std::vector<Frame> straight_frames(const RingGrid& grid) {
  std::vector<Frame> frames;
  for (double s : grid.s)
    frames.push_back({Vec3(0, 0, s), Vec3::UnitZ(), Vec3::UnitX(), Vec3::UnitY()});
  return frames;
}

double mean_diameter(const System& system, const Stent& stent) {
  const std::vector<double> radii = ring_radii(system, stent.body, stent.grid);
  return 2 * std::accumulate(radii.begin(), radii.end(), 0.0) / static_cast<double>(radii.size());
}

double chain_length(const Vectors& points) {
  double length = 0;
  for (std::size_t k = 1; k < points.size(); ++k)
    length += (points[k] - points[k - 1]).norm();
  return length;
}

/// Brings the system to force balance and returns the residual. Throws if there is no balance.
/// @param state name of the state, for the message
double relax_or_throw(System& system, Interactions& interactions, const Numerics& numerics, const std::string& state) {
  const RelaxResult r = relax(system, interactions, numerics.integrator);
  if (!r.converged)
    throw common::ComputationError("the stent on the bench did not reach force balance", state,
                                   "residual " + std::to_string(r.residual), "raise numerics.maximal_steps_per_stage");
  return r.residual;
}

/// Adds the balloon and opens the stent with it, up to the pressure of the balloon's nominal diameter. Returns the
/// largest residual of the balanced states.
double open_by_balloon(System& system, const Stent& stent, const StentSpec& spec, BalloonSpec balloon_spec,
                       const Numerics& numerics) {
  balloon_spec.folding.reset(); // folds do not matter: they open before the stent yields
  const RingGrid grid = balloon_grid(balloon_spec, numerics.device_edge);
  std::vector<double> radii;
  for (double share : grid.start_ratio)
    radii.push_back(std::min(0.5 * balloon_spec.crimped_diameter * share, 0.45 * spec.crimped_diameter - clearance));
  const double pressure =
      BalloonChart(balloon_spec.chart_pressure_bar, balloon_spec.chart_diameter, balloon_spec.crimped_diameter)
          .pressure_at(balloon_spec.nominal_diameter) *
      mpa_per_bar;
  balloon_spec.chart_pressure_bar =
      pressures_without_stent(spec, std::move(balloon_spec.chart_pressure_bar), balloon_spec.chart_diameter);
  Balloon balloon = add_balloon(system, balloon_spec, grid, straight_frames(grid), radii);
  Interactions interactions;
  interactions.contacts.emplace_back(balloon.body, stent.body, numerics.contact);
  double residual = 0;
  for (double share : {opening_pressure_share, 1.0}) {
    set_pressure(balloon, share * pressure);
    residual = std::max(residual, relax_or_throw(system, interactions, numerics, "inflation"));
  }
  return residual;
}

} // namespace

CrushTest crush(const StentSpec& spec, const BalloonSpec& balloon, const Numerics& settings) {
  Numerics numerics = settings;
  numerics.integrator.displacement_per_step *= 0.5; // longer steps may fold a wide stent
  System system;
  RingGrid grid = stent_grid(spec, numerics.device_edge);
  const std::vector<double> radii(grid.s.size(), 0.5 * spec.crimped_diameter);
  const std::vector<Frame> frames = straight_frames(grid);
  const Stent stent = add_stent(system, spec, "stent", std::move(grid), frames, radii);
  std::vector<Anchors::Element> anchors;
  for (int v = 0; v < system.vertices(); ++v)
    anchors.push_back({v, system.x[v], anchor_stiffness});
  system.add_force(stent.body, std::make_unique<Anchors>(anchors));
  Pressure& outside_pressure =
      system.add_force(stent.body, std::make_unique<Pressure>(system.body(stent.body).triangles, system.x, 0.0));
  std::vector<int> all(system.vertices());
  std::iota(all.begin(), all.end(), 0);
  const double area = pi * spec.nominal_diameter * spec.length / system.vertices();
  Crimper& crimper = system.add_force(stent.body, std::make_unique<Crimper>(std::move(all), crimper_stiffness * area));

  CrushTest test{};
  test.residual = open_by_balloon(system, stent, spec, balloon, numerics);
  test.inflated_diameter = mean_diameter(system, stent);
  system.remove_last_body();
  Interactions no_interactions;
  outside_pressure.set(-free_pressure_share * spec.radial_strength_mpa);
  test.residual = std::max(test.residual, relax_or_throw(system, no_interactions, numerics, "recoil"));
  test.free_diameter = mean_diameter(system, stent);
  test.recoil_percent = 100 * (1 - test.free_diameter / test.inflated_diameter);
  outside_pressure.set(0);
  double loss = 0, pressure = 0;
  for (int k = 1; loss < reported_losses_percent[3]; ++k) {
    const double before = loss, pressure_before = pressure;
    crimper.set_radius(0.5 * test.free_diameter * (1 - k * closing_step));
    test.residual = std::max(test.residual, relax_or_throw(system, no_interactions, numerics, "crushing"));
    const double diameter = mean_diameter(system, stent);
    pressure = crimper.total_force(system.x) /
               (pi * test.free_diameter * chain_length(ring_centres(system, stent.body, stent.grid)));
    loss = 100 * (1 - diameter / test.free_diameter);
    for (double wanted : reported_losses_percent)
      if (before < wanted && loss >= wanted)
        test.points.push_back(
            {wanted, pressure_before + (pressure - pressure_before) * (wanted - before) / (loss - before)});
  }
  return test;
}

} // namespace vci
