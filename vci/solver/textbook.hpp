// The textbook scheme: small fixed steps, plain conjugate gradients, stopped by velocity. The baseline to compare with.
#pragma once
#include "vci/solver/integrator.hpp"

namespace vci {

/// Steps (M / h^2 + D / h + K) dx = f + M v / h, all of one length h. D is the damping of the forces that have one.
/// After each step the velocity is dx / h times settings.velocity_kept. A stage ends when the root mean square of the
/// velocity over the free vertices is at most settings.velocity_stop.
/// Slow vertices do not mean that the forces balance. So the result also holds the residual, as relax() measures it.
RelaxResult relax_textbook(System& system, Interactions& interactions, const IntegratorSettings& settings,
                           Balance* balance = nullptr);

} // namespace vci
