// A balloon as its maker describes it.
#pragma once
#include <optional>
#include <vector>

namespace vci {

/// How a balloon is folded before it is inflated.
struct FoldingSpec {
  int wings = 3;
  double shaft_diameter = 0.5, membrane_thickness = 0.02; ///< mm
  bool clockwise = false; ///< sense of the wrap from valley to crest, seen against the vessel's direction
};

struct BalloonSpec {
  double nominal_diameter, length; ///< mm, the length without shoulders
  double shoulder = 1.2;           ///< mm, of each
  double crimped_diameter;         ///< mm
  double rated_burst_pressure_bar;
  std::vector<double> chart_pressure_bar, chart_diameter; ///< bar, mm
  std::optional<FoldingSpec> folding = std::nullopt;      ///< none: a small tube that unfolds softly
};

} // namespace vci
