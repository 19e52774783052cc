// The textbook scheme, a baseline for comparisons: small fixed steps and plain conjugate gradients, until velocities
// are small.
#pragma once
#include "vci/solver/integrator.hpp"

namespace vci {

/// Each step solves (M / h^2 + D / h + K) dx = f + M v / h, with the fixed length h. M is the lumped mass, K the
/// stiffness, and D the damping matrix (Force::add_damping()). After each step the velocity v is dx / h times
/// settings.velocity_kept. A stage ends when the root mean square of v over the free vertices is at most
/// settings.velocity_stop. Slow vertices do not mean that the forces balance. So the result also holds the residual of
/// measure_balance().
RelaxResult relax_textbook(System& system, Interactions& interactions, const IntegratorSettings& settings,
                           Balance* balance = nullptr);

} // namespace vci
