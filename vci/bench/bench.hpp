// Bench tests of single devices in air.
#pragma once
#include "vci/devices/balloon/balloon_spec.hpp"
#include "vci/scene/numerics.hpp"

namespace vci {

struct InflationPoint {
  double pressure_bar, chart_diameter_mm, diameter_mm, length_mm, residual;
  int steps;
};
/// Free expansion of a balloon at the given pressures, or at its chart's. Throws common::ComputationError if force
/// balance is not reached at a pressure.
std::vector<InflationPoint> inflate(const BalloonSpec& spec, const Numerics& numerics,
                                    const std::vector<double>& pressure_bar);

} // namespace vci
