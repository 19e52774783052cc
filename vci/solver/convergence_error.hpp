// The error of a stage that did not reach force balance.
#pragma once
#include "common/error.hpp"
#include "vci/solver/integrator.hpp"

namespace vci {

/// The place of the deepest penetration, as " (balloon in stent at (x, y, z))" in mm; empty if there is none.
std::string deepest_place(const RelaxResult& result, const System& system);

/// The error, with the residual, the steps, and the place of the largest force left. @param where step and stage
common::ComputationError no_balance(const std::string& where, const RelaxResult& result,
                                    const IntegratorSettings& settings, const System& system);

} // namespace vci
