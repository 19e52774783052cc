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
  explicit Tube(bool in_tissue = true, double calcium_mm = 0) {
    tests::Vessel vessel{length, radius, 0, 0};
    vessel.around = 48, vessel.rows = 120;
    Lumen lumen = vessel.lumen();
    if (calcium_mm > 0) {
      lumen.plaque.assign(lumen.points.size(), calcium_mm);
      lumen.plaque_type.assign(lumen.points.size(), 3);
    }
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

/// A section that becomes oval without stretch: u_r = w cos(2 phi), u_phi = -w / 2 sin(2 phi). Its curvature changes by
/// 3 w cos(2 phi) / a^2.
double oval_rigidity(Tube tube, double outer_radius) {
  constexpr double w = 1e-5;
  const double work = tube.work([=](const Vec3& p) {
    const double phi = std::atan2(p[1], p[0]), radial = w * std::cos(2 * phi), round = -0.5 * w * std::sin(2 * phi);
    return Vec3(radial * std::cos(phi) - round * std::sin(phi), radial * std::sin(phi) + round * std::cos(phi), 0);
  });
  // The wall at the outer radius has the lumen's angles, so its curvature changes by a / b of the lumen's.
  const double change = 3 * w / (radius * outer_radius);
  return work / (0.5 * pi * outer_radius * length * change * change);
}

/// The hinges are three to four times as stiff as a plate here, whatever their rigidity. So stiffnesses are compared.
TEST(Wall, CalciumBendsAsAPlate) {
  const WallSpec w = Tube(false).spec;
  const auto plate = [&](double modulus, double t) {
    return modulus * t * t * t / (12 * (1 - w.poisson_ratio * w.poisson_ratio));
  };
  const double calcium_mm = 0.5, b = radius + calcium_mm, opened_mm = std::sqrt(2 * b * b - radius * radius) - b;
  const double expected = 1 + plate(w.plaque[3].youngs_modulus, opened_mm) / plate(w.youngs_modulus, w.thickness);
  const double found = oval_rigidity(Tube(false, calcium_mm), b) / oval_rigidity(Tube(false), radius);
  EXPECT_NEAR(found / expected, 1, 0.4);
}

} // namespace
