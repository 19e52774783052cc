// The error of a stage that did not reach force balance.
#pragma once
#include "common/error.hpp"
#include "vci/solver/integrator.hpp"

namespace vci {

/// Text on the place of the deepest penetration, such as " (balloon in stent at (x, y, z))", with coordinates in mm.
/// Empty if nothing penetrates.
std::string describe_deepest(const RelaxResult& result, const System& system);

/// The error of a stage without balance. Its message gives the residual, the number of steps and the place of the
/// largest net force.
/// @param where step and stage, for the message
common::ComputationError convergence_error(const std::string& where, const RelaxResult& result,
                                           const IntegratorSettings& settings, const System& system);

} // namespace vci
