// The hoop law of a balloon, by its compliance chart.
#pragma once
#include "vci/devices/balloon/balloon_chart.hpp"
#include "vci/mechanics/fibre.hpp"

namespace vci {

/// Tension of the edges round a balloon's rings. The vertices of a free ring under pressure p lie on a circle of the
/// chart's diameter D(p). A ring of n edges of length l has D = l / sin(pi/n). The tension of its edges is
/// p(D) l / (2 tan(pi/n)) per axial length.
class HoopChart : public EdgeForce {
public:
  struct Hoop {
    int i, j;
    double width;   ///< axial length that the edge represents, mm
    double profile; ///< diameter of the ring over that of the balloon's body: 1 in the body, less in the shoulders
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
