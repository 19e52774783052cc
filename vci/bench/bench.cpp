#include "vci/bench/bench.hpp"
#include "common/error.hpp"
#include "vci/devices/balloon/balloon.hpp"
#include "vci/procedure/unfolding.hpp"

namespace vci {

std::vector<InflationPoint> inflate(const BalloonSpec& spec, const Numerics& numerics,
                                    const std::vector<double>& pressure_bar) {
  System system;
  const RingGrid grid = balloon_grid(spec, numerics.device_edge);
  std::vector<Frame> frames;
  std::vector<double> radii;
  for (int r = 0; r < grid.rings(); ++r) {
    frames.push_back({Vec3(0, 0, grid.s[r]), Vec3::UnitZ(), Vec3::UnitX(), Vec3::UnitY()});
    radii.push_back(0.5 * spec.crimped_diameter * grid.start_ratio[r]);
  }
  Balloon balloon = add_balloon(system, spec, grid, frames, radii);
  Interactions interactions;
  add_layer_contacts(interactions, system, balloon, spec, numerics.contact);
  bool unfolds = true;
  std::vector<InflationPoint> points;
  const BalloonChart chart(spec.chart_pressure_bar, spec.chart_diameter, spec.crimped_diameter);
  for (double p : pressure_bar) {
    set_pressure(balloon, p * mpa_per_bar);
    const RelaxResult r = relax(system, interactions, folded_balloon_settings(numerics.integrator, spec, unfolds));
    unfolds = false;
    if (!r.converged)
      throw common::ComputationError("the free balloon did not reach force balance", std::to_string(p) + " bar",
                                     "residual " + std::to_string(r.residual),
                                     "raise numerics.maximal_steps_per_stage");
    const int middle = grid.rings() / 2;
    const Vectors centres = ring_centres(system, balloon.body, grid);
    points.push_back({p, chart.diameter_at(p), 2 * ring_radii(system, balloon.body, grid)[middle],
                      (centres.back() - centres.front()).norm(), r.residual, r.steps});
  }
  return points;
}

} // namespace vci
