#include "vci/devices/balloon/balloon_chart.hpp"

#include <algorithm>
#include <stdexcept>

namespace vci {

namespace {

constexpr double buckled_stiffness_ratio = 0.02; // stiffness of a film in compression over that in tension

} // namespace

BalloonChart::BalloonChart(const std::vector<double>& pressure_mpa, const std::vector<double>& diameter_mm,
                           double crimped_diameter_mm) {
  if (pressure_mpa.size() < 2 || pressure_mpa.size() != diameter_mm.size())
    throw std::invalid_argument("a balloon chart needs two points or more, as many pressures as diameters");
  // The balloon is taken to be unfolded at half the first pressure, with the diameter that the chart's first slope
  // gives there.
  const double slope = (diameter_mm[1] - diameter_mm[0]) / (pressure_mpa[1] - pressure_mpa[0]);
  const double unfolded_pressure = 0.5 * pressure_mpa[0];
  pressure_ = {0.0, unfolded_pressure};
  diameter_ = {crimped_diameter_mm, diameter_mm[0] - slope * (pressure_mpa[0] - unfolded_pressure)};
  pressure_.insert(pressure_.end(), pressure_mpa.begin(), pressure_mpa.end());
  diameter_.insert(diameter_.end(), diameter_mm.begin(), diameter_mm.end());
  for (std::size_t k = 1; k < pressure_.size(); ++k)
    if (!(pressure_[k] > pressure_[k - 1]) || !(diameter_[k] > diameter_[k - 1]))
      throw std::invalid_argument("a balloon chart must rise in pressure and diameter from the crimped balloon on");
}

BalloonChart BalloonChart::of_unfolded(const std::vector<double>& pressure_mpa,
                                       const std::vector<double>& diameter_mm) {
  const double slope = (pressure_mpa[1] - pressure_mpa[0]) / (diameter_mm[1] - diameter_mm[0]);
  const double unfolded = diameter_mm[0] - pressure_mpa[0] / slope;
  if (!(unfolded > 0))
    throw std::invalid_argument("a balloon chart that has no diameter at no pressure, by its first slope");
  BalloonChart chart;
  chart.pressure_ = {-buckled_stiffness_ratio * slope * 0.5 * unfolded, 0.0};
  chart.diameter_ = {0.5 * unfolded, unfolded};
  chart.pressure_.insert(chart.pressure_.end(), pressure_mpa.begin(), pressure_mpa.end());
  chart.diameter_.insert(chart.diameter_.end(), diameter_mm.begin(), diameter_mm.end());
  return chart;
}

std::size_t BalloonChart::segment_of_diameter(double diameter_mm) const {
  const auto it = std::upper_bound(diameter_.begin() + 1, diameter_.end() - 1, diameter_mm);
  return static_cast<std::size_t>(it - diameter_.begin());
}

double BalloonChart::slope_at(double diameter_mm) const {
  const std::size_t k = segment_of_diameter(diameter_mm);
  return (pressure_[k] - pressure_[k - 1]) / (diameter_[k] - diameter_[k - 1]);
}

double BalloonChart::pressure_at(double diameter_mm) const {
  const std::size_t k = segment_of_diameter(diameter_mm);
  return pressure_[k - 1] + slope_at(diameter_mm) * (diameter_mm - diameter_[k - 1]);
}

double BalloonChart::first_moment(double diameter_mm) const {
  const std::size_t last = segment_of_diameter(diameter_mm);
  double sum = 0;
  for (std::size_t k = 1; k <= last; ++k) {
    const double a = diameter_[k - 1], b = k == last ? diameter_mm : diameter_[k];
    const double slope = (pressure_[k] - pressure_[k - 1]) / (diameter_[k] - a), base = pressure_[k - 1] - slope * a;
    sum += base * (b * b - a * a) / 2 + slope * (b * b * b - a * a * a) / 3;
  }
  return sum;
}

double BalloonChart::diameter_at(double pressure_mpa) const {
  const auto it = std::upper_bound(pressure_.begin() + 1, pressure_.end() - 1, pressure_mpa);
  const auto k = static_cast<std::size_t>(it - pressure_.begin());
  const double slope = (diameter_[k] - diameter_[k - 1]) / (pressure_[k] - pressure_[k - 1]);
  return diameter_[k - 1] + slope * (pressure_mpa - pressure_[k - 1]);
}

} // namespace vci
