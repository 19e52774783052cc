// The error of a stage that did not reach force balance.
#pragma once
#include "common/error.hpp"
#include "vci/solver/integrator.hpp"

namespace vci {

/// Where the deepest penetration is: " (balloon in stent at (x, y, z))", mm; empty where nothing is deeper than contact
/// begins.
std::string deepest_place(const RelaxResult& result, const System& system);

/// Residual, steps, and where the largest force is left. @param where step and stage
common::ComputationError no_balance(const std::string& where, const RelaxResult& result,
                                    const IntegratorSettings& settings, const System& system);

} // namespace vci
