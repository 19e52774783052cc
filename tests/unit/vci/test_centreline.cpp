// The angle by which a path turns: along a bend, along a bend and a straight piece, and along an S-shaped bend.
#include "vci/geometry/centreline.hpp"
#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace {

using namespace vci;

constexpr double radius = 8, arc = 10, piece = 0.25; // mm

/// Two arcs of 10 mm in one plane. The first has a radius of 8 mm, the second has `sign` times its curvature.
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
  for (double span : {2.0, 4.0}) { // half a span at each end is not counted
    EXPECT_NEAR(two_bends(1).turning(0, 2 * arc, span), (2 * arc - span) / radius, 2e-3);
    EXPECT_NEAR(two_bends(0).turning(0, 2 * arc, span), (arc - 0.5 * span) / radius, 0.02);
  }
}

TEST(Path, BendsThatUndoEachOtherTurnItAllTheSame) {
  const Path path = two_bends(-1);
  EXPECT_NEAR(path.tangent(1).dot(path.tangent(2 * arc - 1)), 1, 1e-3) << "its ends are parallel";
  EXPECT_NEAR(path.turning(0, 2 * arc, 2.5), 2 * (arc - 2.5) / radius, 0.02)
      << "the piece about the change is straight";
}

TEST(Path, PointsThatScatterDoNotTurnIt) {
  Vectors points;
  for (int k = 0; k <= 48; ++k) // 12 mm along x, scattered by up to 0.01 mm to either side
    points.push_back({0.25 * k, 0.01 * ((k * 7919 % 13) / 6.0 - 1), 0.01 * ((k * 104729 % 11) / 5.0 - 1)});
  const double degree = pi / 180;
  EXPECT_LT(Path(points, 0).turning(0, 12, 3), 0.5 * degree);
  EXPECT_GT(Path(points, 0).turning(0, 12, 1), 1.5 * degree) << "over short pieces it adds up";
}

} // namespace
