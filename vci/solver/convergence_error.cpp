#include "vci/solver/convergence_error.hpp"

#include <sstream>

namespace vci {

namespace {

const std::string& body_name(int vertex, const System& system) {
  int body = system.bodies() - 1;
  while (system.body(body).first > vertex)
    --body;
  return system.body(body).name;
}

std::string position_text(int vertex, const System& system) {
  const Vec3& at = system.x[vertex];
  std::ostringstream place;
  place << "at (" << at[0] << ", " << at[1] << ", " << at[2] << ")";
  return place.str();
}

} // namespace

std::string describe_deepest(const RelaxResult& r, const System& system) {
  if (r.deepest[0] < 0)
    return {};
  return " (" + body_name(r.deepest[0], system) + " in " + body_name(r.deepest[1], system) + " " +
         position_text(r.deepest[0], system) + ")";
}

common::ComputationError convergence_error(const std::string& where, const RelaxResult& r,
                                           const IntegratorSettings& settings, const System& system) {
  std::ostringstream value;
  if (settings.textbook) {
    value << "still above velocity_stop_mm_per_ms = " << settings.velocity_stop << " after " << r.steps
          << " steps of fixed_step_ms = " << settings.fixed_step;
    return common::ComputationError("textbook integration did not come to rest", where, value.str(),
                                    "raise numerics.maximal_steps_per_stage; no lumen is written");
  }
  value << "residual " << r.residual << " after " << r.steps << " steps; wanted " << settings.residual_tolerance;
  if (r.stalled)
    value << "; no lower by a tenth for " << settings.stalled_steps << " steps";
  if (r.imbalance.vertex >= 0)
    value << "; largest force left " << r.imbalance.force << " N on the " << body_name(r.imbalance.vertex, system)
          << " " << position_text(r.imbalance.vertex, system) << " mm; deepest penetration " << r.maximal_penetration
          << " mm" << describe_deepest(r, system);
  return common::ComputationError("the deployment did not reach force balance", where, value.str(),
                                  "predilate with a smaller balloon first, refine the lumen, or raise "
                                  "numerics.maximal_steps_per_stage; no lumen is written");
}

} // namespace vci
