// Balloons follow their chart, whatever the number of vertices round them; stents have their radial strength.
#include "vci/bench/bench.hpp"
#include "vci/bench/crush.hpp"
#include "vci/devices/balloon/balloon.hpp"
#include "vci/devices/stent/stent.hpp"
#include "vci/results/strut_pattern.hpp"
#include <algorithm>
#include <cmath>
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

TEST(Crush, StentOfStatedStrengthYieldsThereAfterASmallRecoil) {
  const StentSpec stent{3.0, 8, 1.0, 4.4, 0.08, 8, 2, "b", {}, 0.5, 20, 0.22, 4.5};
  const BalloonSpec delivery{3.0, 8.0, 1.0, 0.8, 16.0, {3, 7, 11, 16}, {2.73, 2.9, 3.0, 3.14}};
  for (double edge : {0.6, 0.45}) {
    Numerics numerics;
    numerics.device_edge = edge;
    const CrushTest test = crush(stent, delivery, numerics);
    EXPECT_NEAR(test.recoil_percent, stent.recoil_percent, 0.3) << "edge " << edge;
    ASSERT_EQ(test.points.size(), 4u);
    for (std::size_t k = 1; k < 4; ++k)
      EXPECT_GT(test.points[k].pressure_mpa, test.points[k - 1].pressure_mpa);
    EXPECT_NEAR(test.points[0].pressure_mpa, 0.22 * 0.01 / stent.yield_strain(), 0.015) << "elastic, at a loss of 1 %";
    EXPECT_GT(test.points[2].pressure_mpa, 0.20) << "edge " << edge;
    EXPECT_LT(test.points[2].pressure_mpa, 0.25) << "edge " << edge;
    EXPECT_LE(test.residual, numerics.integrator.residual_tolerance);
  }
}

TEST(Struts, AreClosedTubesOfTheirThicknessAboutTheirAxes) {
  const StentSpec stent{3.0, 12, 1.0, 4.4, 0.08, 8, 2, "b", 10, 0.5, 20, 0.22, 4.5};
  const RingGrid grid = stent_grid(stent, 0.45);
  const Struts struts = strut_pattern(stent, grid, straight_grid(grid, 1.5));
  double length = 0;
  std::size_t axes = 0;
  for (const auto& line : struts.lines) {
    axes += line.size();
    for (std::size_t k = 1; k < line.size(); ++k)
      length += (struts.points[line[k]] - struts.points[line[k - 1]]).norm();
  }
  EXPECT_GE(struts.lines.size(), 10u + 9u * 2u) << "a row of crowns each 1.2 mm, two links between rows";
  double six_volumes = 0;
  for (const Triangle& t : struts.triangles) {
    for (int v : t)
      ASSERT_TRUE(v >= static_cast<int>(axes) && v < static_cast<int>(struts.points.size()));
    six_volumes += struts.points[t[0]].dot(struts.points[t[1]].cross(struts.points[t[2]]));
  }
  const double hexagon = 1.5 * std::sqrt(3.0) * 0.04 * 0.04;
  EXPECT_NEAR(std::abs(six_volumes) / 6, hexagon * length, 0.03 * hexagon * length);
  for (std::size_t v = axes; v < struts.points.size(); ++v)
    EXPECT_NEAR(std::hypot(struts.points[v][0], struts.points[v][1]), 1.5, 0.15); // the grid's sides are chords
}

TEST(DeliveryBalloon, IsSofterThanItsChartByTheStent) {
  const StentSpec stent{3.0, 12, 1.0, 4.4, 0.08, 8, 2, "b", {}, 0.5, 20, 0.22, 4.5};
  EXPECT_NEAR(opening_pressure_mpa(stent, 3.0), 0.22, 1e-12) << "the radial strength at the nominal diameter";
  EXPECT_NEAR(opening_pressure_mpa(stent, 1.0), 0.44 * 3 * 0.22, 1e-12) << "Laplace: less tension, smaller radius";
  const std::vector<double> alone = pressures_without_stent(stent, {2, 11, 16}, {2.9, 3.0, 3.14});
  EXPECT_NEAR(alone[1], 11 - 2.2, 1e-9);
  EXPECT_GT(alone[0], 0) << "a chart with a pressure that cannot open the stent";
  EXPECT_TRUE(std::is_sorted(alone.begin(), alone.end()));
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
