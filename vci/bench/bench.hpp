// Bench tests of single devices in air.
#pragma once
#include "vci/devices/balloon/balloon_spec.hpp"
#include "vci/scene/numerics.hpp"

namespace vci {

/// A free balloon in force balance at one pressure. chart_diameter_mm is the diameter by the maker's chart; diameter
/// and length are computed. Residual and number of steps are the solver's.
struct InflationPoint {
  double pressure_bar, chart_diameter_mm, diameter_mm, length_mm, residual;
  int steps;
};
/// Inflates a balloon in air to one pressure (bar) after the other. Diameters are measured at the middle ring, lengths
/// between the end rings. Throws common::ComputationError if force balance is not reached at a pressure.
std::vector<InflationPoint> inflate(const BalloonSpec& spec, const Numerics& numerics,
                                    const std::vector<double>& pressure_bar);

} // namespace vci
