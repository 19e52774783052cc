// How far a path turns: a bend, half a bend, and a bend undone by its reverse.
#include "vci/centreline.hpp"
#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace {

using namespace vci;

constexpr double radius = 8, arc = 10, piece = 0.25; // mm

/// Two arcs of the radius, the second bent by `sign` times as much, in one plane.
Path two_bends(double sign) {
  Vectors points{Vec3::Zero()};
  Vec3 tangent = Vec3::UnitX();
  for (double s = 0; s < 2 * arc - 1e-9; s += piece) {
    const double angle = (s < arc ? 1 : sign) * piece / radius;
    const Eigen::AngleAxisd half(0.5 * angle, Vec3::UnitZ());
    tangent = half * tangent;
    points.push_back(points.back() + piece * tangent);
    tangent = half * tangent;
  }
  return {points, 0};
}

TEST(Path, TurnsByItsBend) {
  const double all = 2 * arc / radius;
  EXPECT_NEAR(two_bends(1).turning(1, 2 * arc - 1), all - 2 / radius, 1e-3);
  EXPECT_NEAR(two_bends(0).turning(1, 2 * arc - 1), arc / radius - 1 / radius, 1e-3);
}

TEST(Path, BendsThatUndoEachOtherTurnItAllTheSame) {
  const Path path = two_bends(-1);
  EXPECT_NEAR(path.tangent(1).dot(path.tangent(2 * arc - 1)), 1, 1e-3) << "its ends are parallel";
  const double all = 2 * (arc - 1) / radius;
  EXPECT_LT(path.turning(1, 2 * arc - 1), all);
  EXPECT_GT(path.turning(1, 2 * arc - 1), all - 1.0 / radius) << "the last millimetre before the change counts in part";
}

} // namespace
