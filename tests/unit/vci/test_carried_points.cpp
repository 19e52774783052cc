// Points that follow the displacement of a coarse tube. They follow a translation to rounding, and a rotation and a
// widening to about 1e-3 mm. For other displacements the error falls with the third power of the edge length.
#include "vci/geometry/carried_points.hpp"
#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <stdexcept>

namespace {

using namespace vci;

constexpr double tube_radius = 1.5, tube_length = 6; // mm

struct Tube {
  Vectors points;
  Triangles triangles;
};

/// A tube along z with triangles of about this edge (mm); every other ring is turned by half a step.
Tube tube(double edge) {
  const int around = static_cast<int>(std::lround(2 * pi * tube_radius / edge));
  const int rings = static_cast<int>(std::lround(tube_length / edge));
  Tube t;
  for (int r = 0; r <= rings; ++r)
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * pi * (k + 0.5 * (r % 2)) / around;
      t.points.emplace_back(tube_radius * std::cos(angle), tube_radius * std::sin(angle), tube_length * r / rings);
    }
  for (int r = 0; r < rings; ++r)
    for (int k = 0; k < around; ++k) {
      const int a = r * around + k, b = r * around + (k + 1) % around, c = a + around, d = b + around;
      t.triangles.push_back({a, b, r % 2 == 0 ? c : d});
      t.triangles.push_back(r % 2 == 0 ? Triangle{b, d, c} : Triangle{a, d, c});
    }
  return t;
}

template <class Map> Vectors mapped(const Vectors& points, Map map) {
  Vectors after;
  for (const Vec3& p : points)
    after.push_back(map(p));
  return after;
}

/// Largest distance (mm) between carried points and their exact places. Points within 0.8 mm of an end are left out.
template <class Map> double largest_error(double edge, Map map) {
  const Tube coarse = tube(edge), fine = tube(0.17);
  const Vectors found =
      CarriedPoints(coarse.triangles, coarse.points, fine.points).displaced_points(mapped(coarse.points, map));
  double largest = 0;
  for (std::size_t k = 0; k < found.size(); ++k)
    if (fine.points[k].z() > 0.8 && fine.points[k].z() < tube_length - 0.8)
      largest = std::max(largest, (found[k] - map(fine.points[k])).norm());
  return largest;
}

TEST(CarriedPoints, FollowShiftAndTurnToRounding) {
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  // A rotation is not exact, because planar_regularisation in carried_points.cpp reduces the gradient across the wall.
  EXPECT_LT(largest_error(0.8, [&](const Vec3& p) { return Vec3(p + Vec3(3, -2, 5)); }), 1e-12);
  EXPECT_LT(largest_error(0.8, [&](const Vec3& p) { return Vec3(turn * p); }), 1e-3);
}

TEST(CarriedPoints, WidenAsATubeDoes) {
  const auto wider = [](const Vec3& p) { return Vec3(1.6 * p.x(), 1.6 * p.y(), p.z()); };
  // Without gradients, a point between two vertices would follow their chord, which widens less than the circle.
  const double error_of_chord = 0.6 * tube_radius * (1 - std::cos(0.4 / tube_radius));
  EXPECT_LT(largest_error(0.8, wider), 0.05 * error_of_chord);
}

TEST(CarriedPoints, ErrorFallsWithTheThirdPowerOfTheEdge) {
  const auto lesion_opened = [](const Vec3& p) {
    const double wave = 1 + 0.3 * std::cos(2 * pi * p.z() / 6) + 0.1 * p.x();
    return Vec3(wave * p.x(), wave * p.y(), p.z() + 0.1 * std::sin(p.z()));
  };
  const double coarse = largest_error(0.8, lesion_opened), half = largest_error(0.4, lesion_opened);
  EXPECT_LT(coarse, 0.012);
  EXPECT_GT(std::log2(coarse / half), 2.5) << coarse << " " << half;
}

TEST(CarriedPoints, ValuesAreLinearAndDistancesKnown) {
  const Tube coarse = tube(0.8);
  const Vectors points{0.5 * (coarse.points[0] + coarse.points[1]), Vec3(tube_radius + 1, 0, 3)};
  const CarriedPoints carried(coarse.triangles, coarse.points, points);
  std::vector<double> z;
  for (const Vec3& p : coarse.points)
    z.push_back(p.x());
  EXPECT_NEAR(carried.interpolate(z)[0], points[0].x(), 1e-12);
  EXPECT_NEAR(carried.distances()[0], 0, 1e-12);
  EXPECT_NEAR(carried.distances()[1], 1, 0.06);
  EXPECT_THROW(CarriedPoints({}, {}, points), std::invalid_argument);
}

} // namespace
