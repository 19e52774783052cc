// A balloon as its maker describes it.
#pragma once
#include <optional>
#include <vector>

namespace vci {

/// How a balloon is folded before it is inflated.
struct FoldingSpec {
  int wings = 3;
  double shaft_diameter = 0.5, membrane_thickness = 0.02; ///< mm
  bool clockwise = false; ///< sense in which wings are wrapped from valley to crest, seen by a viewer looking upstream
};

struct BalloonSpec {
  double nominal_diameter, length; ///< mm; the length is that of the cylinder, without shoulders
  double shoulder = 2.0;           ///< length of each shoulder, mm
  double crimped_diameter;         ///< mm
  double rated_burst_pressure_bar;
  std::vector<double> chart_pressure_bar, chart_diameter; ///< bar, mm
  std::optional<FoldingSpec> folding = std::nullopt;      ///< none: the balloon starts as a small tube
};

} // namespace vci
