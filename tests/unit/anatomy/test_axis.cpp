#include "centreline/axis.hpp"
#include <gtest/gtest.h>
#include <random>

using namespace anatomy;

namespace {

std::vector<Vec3> helix(double radius, double pitch_per_rad, double length, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  std::vector<Vec3> points;
  const double per_rad = std::hypot(radius, pitch_per_rad);
  for (double s = 0; s <= length + 1e-9; s += 0.25) {
    const double a = s / per_rad;
    points.emplace_back(radius * std::cos(a) + noise * normal(random), radius * std::sin(a) + noise * normal(random),
                        pitch_per_rad * a + noise * normal(random));
  }
  return points;
}

double mean_curvature(const Axis& axis) {
  double sum = 0;
  int n = 0;
  for (double s = 2; s < axis.length() - 2; s += 0.1, ++n)
    sum += axis.curvature(s);
  return sum / n;
}

TEST(Axis, NoiseIsEstimated) {
  EXPECT_NEAR(noise_of(helix(10, 0, 60, 0.02, 1)), 0.02, 0.004);
  EXPECT_LT(noise_of(helix(10, 0, 60, 0, 1)), 1e-4);
}

TEST(Axis, CleanHelixKeepsCurvatureTorsionAndLength) {
  const double r = 3, c = 2, k = r / (r * r + c * c), t = c / (r * r + c * c);
  const Axis axis(helix(r, c, 40, 0, 1));
  EXPECT_NEAR(axis.length(), 40, 0.05);
  for (double s = 4; s < 36; s += 1) {
    EXPECT_NEAR(axis.curvature(s), k, 0.01 * k) << s;
    EXPECT_NEAR(axis.torsion(s), t, 0.05 * t) << s;
  }
}

TEST(Axis, NoisyArcKeepsItsMeanCurvature) {
  // 0.02 mm of white noise on bins of the axis is more than 0.05 mm on the surface gives
  for (unsigned seed : {1u, 2u, 3u}) {
    const Axis axis(helix(1 / 0.15, 0, 40, 0.02, seed));
    EXPECT_NEAR(mean_curvature(axis), 0.15, 0.05 * 0.15) << seed;
  }
}

TEST(Axis, MeetsItsEndsAndIsStraightForTwoPoints) {
  const std::vector<Vec3> points = helix(8, 1, 20, 0.02, 4);
  const Axis axis(points);
  EXPECT_LT((axis.at(0) - points.front()).norm(), 1e-3);
  EXPECT_LT((axis.at(axis.length()) - points.back()).norm(), 1e-3);
  const Axis line({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0), Vec3(3, 0, 0)});
  EXPECT_NEAR(line.curvature(1.5), 0, 1e-6);
  EXPECT_EQ(line.torsion(1.5), 0);
  EXPECT_NEAR((line.tangent(1) - Vec3(1, 0, 0)).norm(), 0, 1e-9);
}

} // namespace
