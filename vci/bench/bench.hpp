// Bench tests of single devices in air.
#pragma once
#include "vci/devices/balloon/balloon_spec.hpp"
#include "vci/scene/numerics.hpp"

namespace vci {

/// A balloon in balance at a pressure: its diameter by the maker's chart and as computed, and the solver's result.
struct InflationPoint {
  double pressure_bar, chart_diameter_mm, diameter_mm, length_mm, residual;
  int steps;
};
/// Free expansion of a balloon in air, at one pressure (bar) after the other. Diameters are of the middle ring, lengths
/// are those between the end rings. Throws common::ComputationError if force balance is not reached at a pressure.
std::vector<InflationPoint> inflate(const BalloonSpec& spec, const Numerics& numerics,
                                    const std::vector<double>& pressure_bar);

} // namespace vci
