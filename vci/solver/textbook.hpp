// The textbook scheme: small fixed steps, plain conjugate gradients, stopped by velocity. The baseline to compare with.
#pragma once
#include "vci/solver/integrator.hpp"

namespace vci {

/// Steps (M / h^2 + D / h + K) dx = f + M v / h of one length h, D the damping of the forces that have one, the
/// velocity dx / h times settings.velocity_kept after each; done when its root mean square over the free vertices is at
/// most settings.velocity_stop. This does not say that the forces balance: the result holds the residual that relax()
/// stops by, to be read beside it.
RelaxResult relax_textbook(System& system, Interactions& interactions, const IntegratorSettings& settings,
                           Balance* balance = nullptr);

} // namespace vci
