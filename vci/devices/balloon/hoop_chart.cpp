#include "vci/devices/balloon/hoop_chart.hpp"

#include <cmath>

namespace vci {

HoopChart::HoopChart(const std::vector<Hoop>& hoops, int edges_per_ring, BalloonChart chart)
    : hoops_(hoops), chart_(std::move(chart)) {
  const double tangent = std::tan(pi / edges_per_ring);
  diameter_per_edge_ = 1 / std::sin(pi / edges_per_ring);
  half_cotangent_ = 0.5 / tangent;
  for (const Hoop& h : hoops_)
    add_edge(h.i, h.j);
}

EdgeForce::Tension HoopChart::tension(std::size_t k, double length) const {
  const Hoop& h = hoops_[k];
  const double to_diameter = diameter_per_edge_ / h.profile, diameter = to_diameter * length;
  const double scale = half_cotangent_ * h.width;
  const double pressure = chart_.pressure_at(diameter);
  // The energy is the integral of the tension over the length, from the chart's smallest diameter on.
  return {scale * chart_.first_moment(diameter) / (to_diameter * to_diameter), scale * pressure * length,
          scale * (pressure + length * to_diameter * chart_.slope_at(diameter))};
}

} // namespace vci
