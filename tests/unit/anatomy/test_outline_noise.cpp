#include "measure/outline_noise.hpp"
#include "measure/section_noise.hpp"
#include <gtest/gtest.h>
#include <random>

using namespace anatomy;

namespace {

constexpr unsigned seeds = 200;

// Points `edge` mm apart round a circle whose radius scatters by `noise`.
std::vector<Vec2> circle(double radius, double edge, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto n = static_cast<int>(2 * pi * radius / edge);
  std::vector<Vec2> outline;
  for (int k = 0; k < n; ++k) {
    const double r = radius + noise * normal(random), angle = 2 * pi * k / n;
    outline.emplace_back(r * std::cos(angle), r * std::sin(angle));
  }
  return outline;
}

TEST(OutlineNoise, IsWhatTheMeanRadiusScattersBy) {
  for (const auto& [radius, edge] : {std::pair{1.5, 0.2}, {1.5, 0.12}, {1.5, 0.35}, {0.75, 0.15}, {3.0, 0.4}}) {
    double squares = 0, means = 0;
    for (unsigned seed = 1; seed <= seeds; ++seed) {
      const std::vector<Vec2> outline = circle(radius, edge, 0.05, seed);
      squares += std::pow(mean_radius_scatter(outline, edge), 2) / seeds;
      double mean = 0;
      for (const Vec2& p : outline)
        mean += p.norm() / static_cast<double>(outline.size());
      means += std::pow(mean - radius, 2) / seeds;
    }
    // standard errors: 10 % of the variance of 200 means, 4 % of that of at least 600 waves
    EXPECT_NEAR(std::sqrt(squares / means), 1, 0.15) << radius << " mm, edge " << edge;
  }
}

// Lumens may have the shape of a slit three times as wide as high, or of such a slit bent like a kidney. The noise
// found in them is much less than the least noise that is smoothed away.
TEST(OutlineNoise, IsNoneInASmoothShape) {
  for (double bend : {0.0, 0.3}) {
    std::vector<Vec2> outline;
    for (int k = 0; k < 80; ++k) {
      const double angle = 2 * pi * k / 80, x = 2.2 * std::cos(angle);
      outline.emplace_back(x, 0.75 * std::sin(angle) + bend * x * x / 2.2);
    }
    EXPECT_LT(2 * mean_radius_scatter(outline, 0.12) / 1.5, 0.6 * least_area_noise) << bend;
  }
}

TEST(OutlineNoise, IsNotToldOfACoarseOutline) {
  EXPECT_LT(mean_radius_scatter(circle(0.75, 0.4, 0.05, 1), 0.4), 0);
  EXPECT_LT(mean_radius_scatter(circle(1.5, 1.2, 0, 1), 1.2), 0);
}

TEST(OutlineNoise, KnowsTheEdgesThatWereCut) {
  // A plane through a band of equilateral triangles crosses two edges in each edge's length. If it is slanted, the
  // number differs by up to a seventh.
  std::vector<Vec2> outline = circle(1.5, 0.1, 0, 1);
  EXPECT_NEAR(edge_by_crossings(outline), 0.2, 0.03);
}

} // namespace
