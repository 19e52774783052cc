// Balloons follow their chart, whatever the number of vertices round them.
#include "vci/bench.hpp"
#include <gtest/gtest.h>
#include <stdexcept>

namespace {

using namespace vci;

const BalloonSpec balloon{3.0, 12.0, 1.5, 0.8, 14.0, {2, 6, 10, 14, 18}, {2.76, 2.93, 3.06, 3.19, 3.31}};

TEST(Inflation, FollowsTheChartWithinHalfAPercent) {
  for (double edge : {0.75, 0.45}) { // 12 and 20 vertices round
    Numerics numerics;
    numerics.device_edge = edge;
    for (const InflationPoint& p : inflate(balloon, numerics, {2, 6, 10, 14, 18})) {
      EXPECT_NEAR(p.diameter_mm / p.chart_diameter_mm, 1, 0.005) << p.pressure_bar << " bar, edge " << edge;
      EXPECT_LE(p.residual, numerics.integrator.residual_tolerance);
    }
  }
}

TEST(BalloonChart, InterpolatesAndInverts) {
  const BalloonChart chart({0.2, 0.6, 1.0}, {2.8, 3.0, 3.1}, 0.9);
  EXPECT_NEAR(chart.diameter_at(0.6), 3.0, 1e-12);
  EXPECT_NEAR(chart.pressure_at(2.9), 0.4, 1e-12);
  EXPECT_NEAR(chart.pressure_at(chart.diameter_at(1.4)), 1.4, 1e-12);
  EXPECT_NEAR(chart.pressure_at(0.9), 0, 1e-12);
  EXPECT_LT(chart.slope_at(1.5), 0.1 * chart.slope_at(2.9));
  EXPECT_THROW(BalloonChart({0.2, 0.2}, {2.8, 3.0}, 0.9), std::invalid_argument);
  EXPECT_THROW(BalloonChart({0.2, 0.6}, {2.8, 3.0}, 2.9), std::invalid_argument);
}

} // namespace
