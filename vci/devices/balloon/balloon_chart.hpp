// A maker's compliance chart, continued below its first point down to the crimped balloon.
#pragma once
#include "vci/linalg/types.hpp"

namespace vci {

/// The pressure (MPa) that holds a free balloon at a diameter (mm): a piecewise linear, increasing function. It is 0 at
/// the crimped diameter. Then comes a soft branch, on which the balloon unfolds, up to half the pressure of the chart's
/// first point. The maker's chart follows and is continued with its last slope.
class BalloonChart {
public:
  /// @throws std::invalid_argument unless both columns rise strictly, the chart has two points or more and starts above
  /// the crimped diameter.
  BalloonChart(const std::vector<double>& pressure_mpa, const std::vector<double>& diameter_mm,
               double crimped_diameter_mm);

  /// The chart of a balloon that is unfolded at the start. The maker's chart is continued with its first slope down to
  /// pressure 0. At smaller diameters the film buckles: the slope is a fiftieth, and the pressure negative.
  static BalloonChart of_unfolded(const std::vector<double>& pressure_mpa, const std::vector<double>& diameter_mm);

  double pressure_at(double diameter_mm) const;
  double slope_at(double diameter_mm) const; ///< MPa/mm
  double diameter_at(double pressure_mpa) const;
  /// Integral of p(D) D dD from the chart's smallest diameter on (MPa mm^2), for the work of a ring's tension.
  double first_moment(double diameter_mm) const;

private:
  BalloonChart() = default;
  std::size_t segment_of_diameter(double diameter_mm) const;
  std::vector<double> pressure_, diameter_;
};

} // namespace vci
