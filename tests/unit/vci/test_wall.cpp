// The wall as a tube: what resists it when it moves sideways, when it bends and when it widens.
#include "vci/mechanics/system.hpp"
#include "vci/wall/wall.hpp"
#include "vessel.hpp"

#include <functional>
#include <gtest/gtest.h>

namespace {

using namespace vci;

constexpr double radius = 1.5, length = 20; // mm

struct Tube {
  WallSpec spec;
  double map_pa = 12400;
  System system;
  explicit Tube(bool in_tissue = true) {
    tests::Vessel vessel{length, radius, 0, 0};
    vessel.around = 48, vessel.rows = 120;
    const Lumen lumen = vessel.lumen();
    spec.stiffening = 0;
    if (!in_tissue) {
      spec.thickness = 0.1; // thin enough for the bending of the wall itself to be small
      spec.tissue_modulus = spec.tangential_stiffness = map_pa = 0;
    }
    add_wall(system, lumen, std::vector<char>(lumen.points.size(), 1), spec, map_pa);
  }

  /// Work (N mm) that the wall takes up to second order in a displacement of every vertex: -f . u / 2.
  double work(const std::function<Vec3(const Vec3&)>& displacement) {
    const Vectors rest = system.x;
    Vectors elastic(rest.size(), Vec3::Zero()), foundation = elastic, pressure = elastic;
    for (Vec3& p : system.x)
      p += displacement(p);
    system.evaluate(elastic, foundation, pressure, false);
    double sum = 0;
    for (std::size_t i = 0; i < rest.size(); ++i)
      sum -= 0.5 * (elastic[i] + foundation[i] + pressure[i]).dot(system.x[i] - rest[i]);
    system.x = rest;
    return sum;
  }

  /// Stiffness of the tissue per length against sideways motion, N/mm per mm: on the normal displacement u cos(phi)
  /// acts the slope of the ring's law, on the tangential one the tissue's stiffness along the surface.
  double sideways_stiffness() const {
    const double normal = spec.tissue_modulus / (1 + spec.poisson_ratio) / radius - map_pa * 1e-6 / radius;
    return pi * radius * (normal + spec.tangential_stiffness);
  }
};

TEST(Wall, IsHeldAgainstSidewaysMotionByTheTissueAlone) {
  constexpr double shift = 1e-3;
  Tube tube;
  const double found = 2 * tube.work([=](const Vec3&) { return Vec3(shift, 0, 0); }) / (shift * shift * length);
  EXPECT_NEAR(found, tube.sideways_stiffness(), 0.01 * tube.sideways_stiffness());
}

/// A beam bent to a small curvature. Its fibres are stretched by -curvature x, and its sections stay as they are.
TEST(Wall, BendsAsAThinTube) {
  constexpr double curvature = 1e-5; // 1/mm
  Tube tube(false);
  const auto bend = [=](const Vec3& p) {
    const double z = p[2] - length / 2;
    return Vec3(0.5 * curvature * z * z, 0, -curvature * z * p[0]);
  };
  const WallSpec& w = tube.spec;
  const double rigidity =
      w.youngs_modulus * w.thickness / (1 - w.poisson_ratio * w.poisson_ratio) * pi * std::pow(radius, 3);
  const double expected = 0.5 * rigidity * curvature * curvature * length;
  EXPECT_NEAR(tube.work(bend), expected, 0.02 * expected);
}

/// Widening meets the whole wall in plane strain, and the tissue.
TEST(Wall, WidensAsAThinTubeInTissue) {
  constexpr double widening = 1e-4;
  Tube tube;
  const auto widen = [](const Vec3& p) { return Vec3(widening * p[0], widening * p[1], 0); };
  const WallSpec& w = tube.spec;
  const double wall = w.youngs_modulus * w.thickness / (1 - w.poisson_ratio * w.poisson_ratio) / radius;
  const double tissue = w.tissue_modulus / (1 + w.poisson_ratio) - tube.map_pa * 1e-6;
  const double expected = pi * radius * radius * widening * widening * (wall + tissue) * length;
  EXPECT_NEAR(tube.work(widen), expected, 0.02 * expected);
}

} // namespace
