// Radius correction, the baseline method, on a narrowed bend, and its effect on the wall of another branch.
#include "vci/procedure/radius_correction.hpp"
#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace {

using namespace vci;

constexpr double bend = 5, healthy_radius = 1.6, throat_radius = 0.45, axis_length = 12, middle = 6; // mm

double radius_of(double s) {
  const double d = std::abs(s - middle) / 3;
  return healthy_radius - (d < 1 ? (healthy_radius - throat_radius) * 0.5 * (1 + std::cos(pi * d)) : 0);
}

Vec3 axis_point(double s) {
  return bend * Vec3(std::cos(s / bend), std::sin(s / bend), 0);
}

Vec3 wall_point(double s, double angle, double radius) {
  const Vec3 outwards = axis_point(s) / bend;
  return axis_point(s) + radius * (std::cos(angle) * outwards + std::sin(angle) * Vec3::UnitZ());
}

/// Wall of the bend in steps of 0.05 mm along it, 80 points round it.
Lumen narrowed_bend() {
  Lumen l;
  constexpr int rings = 241, around = 80;
  for (int r = 0; r < rings; ++r)
    for (int k = 0; k < around; ++k) {
      const double s = axis_length * r / (rings - 1);
      l.points.push_back(wall_point(s, 2 * pi * k / around, radius_of(s)));
      l.radius.push_back(radius_of(s));
    }
  for (int r = 0; r + 1 < rings; ++r)
    for (int k = 0; k < around; ++k) {
      const int a = r * around + k, b = r * around + (k + 1) % around;
      l.triangles.push_back({a, b, a + around});
      l.triangles.push_back({b, b + around, a + around});
    }
  l.region.assign(l.triangles.size(), 0);
  return l;
}

/// The axis as a file gives it: a polyline with a corner every half millimetre.
std::map<std::string, Path> polyline() {
  Vectors points;
  for (double s = 0; s <= axis_length; s += 0.5)
    points.push_back(axis_point(s));
  return {{"main", Path(points, 0)}};
}

Scene stent_of_three_millimetres() {
  Scene scene;
  scene.balloons["delivery"] = {3.0, 5, 1.0, 0.8, 16, {3, 11, 16}, {2.8, 3.0, 3.2}};
  scene.stents["stent"] = {3.0, 5, 1.0, 4.4, 0.08, 8, 2, "delivery", 12, 0.5, 20, 0.22, 4.5};
  scene.procedure = {{"stent", Action::stent, {{"stent", "main", middle, 11}}}};
  return scene;
}

double expected_radius(const Scene& scene) {
  return 1.5 * (1 - 0.01 * scene.stents.at("stent").recoil_percent);
}

Vec3 normal(const Vectors& x, const Triangles& t, std::size_t k) {
  return (x[t[k][1]] - x[t[k][0]]).cross(x[t[k][2]] - x[t[k][0]]).normalized();
}

TEST(RadiusCorrection, TheSpanTakesTheDevicesRadiusAndTheRestStays) {
  const Lumen l = narrowed_bend();
  const Scene scene = stent_of_three_millimetres();
  const Vectors moved = correct_radius(scene, l, polyline());
  for (std::size_t v = 0; v < moved.size(); ++v) {
    const double s = axis_length * static_cast<double>(v / 80) / 240;
    const double r = std::hypot(std::hypot(moved[v].x(), moved[v].y()) - bend, moved[v].z());
    if (std::abs(s - middle) < 2.3) {
      EXPECT_NEAR(r, expected_radius(scene), 0.01) << "at " << s << " mm"; // the polyline is 0.006 mm off the arc
    } else if (std::abs(s - middle) > 5.7) {
      EXPECT_EQ(moved[v], l.points[v]);
    }
  }
}

TEST(RadiusCorrection, WallThatMovesFarInABendDoesNotFold) {
  const Lumen l = narrowed_bend();
  const Vectors moved = correct_radius(stent_of_three_millimetres(), l, polyline());
  for (std::size_t k = 0; k < l.triangles.size(); ++k) {
    const Vec3 centre = (moved[l.triangles[k][0]] + moved[l.triangles[k][1]] + moved[l.triangles[k][2]]) / 3;
    const Vec3 axis = bend * Vec3(centre.x(), centre.y(), 0).normalized();
    EXPECT_GT(std::abs(normal(moved, l.triangles, k).dot((centre - axis).normalized())), 0.5);
    EXPECT_GT(normal(moved, l.triangles, k).dot(normal(l.points, l.triangles, k)), 0.3);
  }
}

TEST(RadiusCorrection, ANeighboursWallGivesWayAndKeepsItsOrder) {
  Lumen l = narrowed_bend();
  std::map<std::string, Path> paths = polyline();
  // a thin vessel that crosses the throat above it
  const Vec3 over = axis_point(middle), along = over.normalized();
  Vectors line;
  for (double x = -3; x <= 3; x += 0.5)
    line.push_back(over + Vec3(0, 0, 1.5) + x * along);
  paths["side"] = Path(line, 0);
  const std::size_t first = l.points.size();
  for (double x = -3; x <= 3.01; x += 0.25)
    for (double z : {1.1, 1.9}) {
      l.points.push_back(over + Vec3(0, 0, z) + x * along);
      l.radius.push_back(0.4);
    }
  const Vectors moved = correct_radius(stent_of_three_millimetres(), l, paths);
  for (std::size_t v = first; v < l.points.size(); v += 2) {
    const double near_r = (moved[v] - over).norm(), far_r = (moved[v + 1] - over).norm();
    EXPECT_GT(near_r, expected_radius(stent_of_three_millimetres()));
    EXPECT_GT(far_r, near_r);
    EXPECT_LT((moved[v + 1] - l.points[v + 1]).norm(), (moved[v] - l.points[v]).norm() + 1e-12);
  }
}

} // namespace
