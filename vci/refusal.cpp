#include "vci/refusal.hpp"

#include <sstream>

namespace vci {

common::ComputationError no_balance(const std::string& where, const RelaxResult& r, const IntegratorSettings& settings,
                                    const System& system) {
  std::ostringstream value;
  value << "residual " << r.residual << " after " << r.steps << " steps; wanted " << settings.residual_tolerance;
  if (r.stalled)
    value << "; no lower by a tenth for " << settings.stalled_steps << " steps";
  if (r.imbalance.vertex >= 0) {
    const Vec3& at = system.x[r.imbalance.vertex];
    int body = system.bodies() - 1;
    while (system.body(body).first > r.imbalance.vertex)
      --body;
    value << "; largest force left " << r.imbalance.force << " N on the " << system.body(body).name << " at (" << at[0]
          << ", " << at[1] << ", " << at[2] << ") mm; deepest penetration " << r.maximal_penetration << " mm";
  }
  return common::ComputationError("the deployment did not reach force balance", where, value.str(),
                                  "predilate with a smaller balloon first, refine the lumen, or raise "
                                  "numerics.maximal_steps_per_stage; no lumen is written");
}

} // namespace vci
