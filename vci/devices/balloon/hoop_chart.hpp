// The hoop law of a balloon: its compliance chart.
#pragma once
#include "vci/devices/balloon/balloon_chart.hpp"
#include "vci/mechanics/fibre.hpp"

namespace vci {

/// Hoop edges of a balloon ring of n edges: a free ring under pressure p takes the area of a circle of the chart's
/// diameter D(p). With edge l: D = l sqrt(n / (pi tan(pi/n))), tension p(D) l / (2 tan(pi/n)) per axial length.
class HoopChart : public EdgeForce {
public:
  struct Hoop {
    int i, j;
    double width;   ///< axial length that the edge represents, mm
    double profile; ///< ring diameter over the balloon's (1 in its body, less in its shoulders)
  };
  HoopChart(const std::vector<Hoop>& hoops, int edges_per_ring, BalloonChart chart);

protected:
  Tension tension(std::size_t k, double length) const override;

private:
  std::vector<Hoop> hoops_;
  double diameter_per_edge_, half_cotangent_;
  BalloonChart chart_;
};

} // namespace vci
