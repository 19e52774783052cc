// Small deployments in a straight narrowed tube: properties of every result, and the same result twice.
#include "common/error.hpp"
#include "vci/geometry/sections.hpp"
#include "vci/procedure/deployment.hpp"
#include <gtest/gtest.h>

namespace {

using namespace vci;

constexpr double length = 30, healthy = 1.5, narrowing = 0.5;

Lumen tube(double edge) {
  Lumen l;
  const int around = static_cast<int>(std::lround(2 * pi * healthy / edge));
  const int rings = static_cast<int>(std::lround(length / (0.87 * edge))) + 1;
  for (int r = 0; r < rings; ++r) {
    const double s = length * r / (rings - 1), d = (s - length / 2) / 4;
    const double radius = healthy * (1 - (std::abs(d) < 1 ? narrowing * 0.5 * (1 + std::cos(pi * d)) : 0));
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * pi * (k + 0.5 * (r % 2)) / around;
      l.points.push_back({radius * std::cos(angle), radius * std::sin(angle), s});
      l.radius.push_back(radius);
      l.plaque.push_back(healthy - radius);
      l.plaque_type.push_back(healthy - radius > 0.05 ? 1 : 0);
    }
  }
  for (int r = 0; r + 1 < rings; ++r)
    for (int k = 0; k < around; ++k) {
      const int a = r * around + k, b = r * around + (k + 1) % around, c = a + around, d = b + around;
      if (r % 2 == 0) {
        l.triangles.push_back({a, b, c});
        l.triangles.push_back({b, d, c});
      } else {
        l.triangles.push_back({a, b, d});
        l.triangles.push_back({a, d, c});
      }
    }
  l.region.assign(l.triangles.size(), 0);
  return l;
}

std::map<std::string, Path> axis() {
  Vectors points;
  for (double s = 0; s <= length; s += 0.5)
    points.push_back({0, 0, s});
  return {{"main", Path(points, 0)}};
}

Scene scene_with(std::vector<Step> procedure) {
  Scene scene;
  scene.map_pa = 12000;
  scene.wall.plaque = {{{1, 1e300, 0}, {2, 0.12, 0.08}, {0.5, 0.1, 0.05}, {30, 1e300, 0}}};
  scene.numerics.device_edge = 0.6;
  scene.balloons["pre"] = {2.75, 8, 1.2, 0.8, 14, {2, 6, 10, 14}, {2.53, 2.69, 2.81, 2.92}};
  scene.balloons["delivery"] = {3.25, 10, 1.0, 0.8, 16, {3, 7, 11, 16}, {2.96, 3.14, 3.25, 3.4}};
  scene.stents["stent"] = {3.25, 10, 1.0, 4.4, 0.08, 8, 2, "delivery", 12, 0.5, 20, 0.22, 4.5};
  scene.procedure = std::move(procedure);
  return scene;
}

const Step predilatation{"pre", Action::predilatation, {{"pre", "main", length / 2, 10}}};
const Step stenting{"stent", Action::stent, {{"stent", "main", length / 2, 11}}};

double throat(const Lumen& l, const Vectors& points) {
  const Vectors unit_normals = section_normals(points, l.triangles);
  return section_area(points, l.triangles, unit_normals, {0, 0, length / 2 + 0.01}, Vec3::UnitZ());
}

TEST(Sections, ArcsGiveTheAreaOfACoarseTube) {
  const Lumen l = tube(0.8); // twelve vertices round: its chords enclose 4.5 % less than the circle
  const Vectors unit_normals = section_normals(l.points, l.triangles);
  const double circle = pi * healthy * healthy;
  for (double s : {4.0, 4.2, 4.4, 4.6})
    EXPECT_NEAR(section_area(l.points, l.triangles, unit_normals, {0, 0, s}, Vec3::UnitZ()), circle, 0.003 * circle)
        << s;
  const Vec3 oblique = Vec3(0.3, -0.2, 1).normalized();
  EXPECT_NEAR(section_area(l.points, l.triangles, unit_normals, {0, 0, 5}, oblique), circle / oblique[2],
              0.004 * circle);
}

TEST(Deployment, PredilatationAloneLeavesAnAreaBetweenInitialAndInflated) {
  const Lumen l = tube(0.6);
  const DeploymentResult d = deploy(scene_with({predilatation}), l, axis());
  const double inflated = pi * 2.81 * 2.81 / 4;
  EXPECT_GT(throat(l, d.points), 1.3 * throat(l, l.points));
  EXPECT_LT(throat(l, d.points), 0.9 * inflated);
}

TEST(Deployment, StentKeepsTheLumenOpenInBalanceAndTwiceTheSame) {
  const Lumen l = tube(0.6);
  const DeploymentResult d = deploy(scene_with({predilatation, stenting}), l, axis());
  ASSERT_EQ(d.stages.size(), 6u);
  for (const StageReport& s : d.stages) {
    EXPECT_LE(s.result.residual, 3e-3) << s.step << ' ' << s.stage;
    EXPECT_LE(s.result.mean_penetration, 0.05 * 0.0125);
  }
  ASSERT_EQ(d.stents.size(), 1u);
  const double recoil = 1 - d.stents[0].final_diameter / d.stents[0].inflated_diameter();
  EXPECT_GT(recoil, 0.045) << "the vessel adds to what the stent gives back in air";
  EXPECT_LT(recoil, 0.075);
  EXPECT_GT(throat(l, d.points), 0.75 * pi * 3.25 * 3.25 / 4);
  const DeploymentResult again = deploy(scene_with({predilatation, stenting}), l, axis());
  for (std::size_t i = 0; i < d.points.size(); ++i)
    ASSERT_TRUE((d.points[i].array() == again.points[i].array()).all()) << i;
}

TEST(Deployment, RefusesWhereBalanceIsNotReached) {
  Scene scene = scene_with({predilatation});
  scene.numerics.integrator.maximal_steps = 3;
  try {
    deploy(scene, tube(0.6), axis());
    FAIL() << "three steps cannot be enough";
  } catch (const common::ComputationError& e) {
    EXPECT_NE(std::string(e.what()).find("pre / deployment-to-contact"), std::string::npos);
    EXPECT_NE(std::string(e.what()).find("residual"), std::string::npos);
  }
}

TEST(Deployment, GivesUpWhereTheResidualStalls) {
  Scene scene = scene_with({predilatation});
  scene.numerics.integrator.stalled_steps = 2;
  try {
    deploy(scene, tube(0.6), axis());
    FAIL() << "an inflation's residual stands for more than two steps";
  } catch (const common::ComputationError& e) {
    const std::string message = e.what();
    EXPECT_NE(message.find("no lower by a tenth for 2 steps"), std::string::npos) << message;
    EXPECT_NE(message.find("N on the "), std::string::npos) << message;
  }
}

TEST(Deployment, StepsTakenWithCareEndInTheSameBalance) {
  const Lumen l = tube(0.6);
  Scene scene = scene_with({predilatation, stenting});
  const DeploymentResult usual = deploy(scene, l, axis());
  for (const StageReport& s : usual.stages)
    EXPECT_EQ(s.result.careful_from, -1) << s.step << ' ' << s.stage << ": not needed here";
  scene.numerics.integrator.stalled_steps = 48; // careful steps begin after a sixth of them: 8 steps without progress
  const DeploymentResult careful = deploy(scene, l, axis());
  EXPECT_GE(careful.stages[0].result.careful_from, 8);
  EXPECT_TRUE(careful.stages.back().result.converged);
  EXPECT_NEAR(throat(l, careful.points), throat(l, usual.points), 0.005 * throat(l, usual.points));
}

TEST(Sections, APlaneAlongAVesselCutsNoLoopWithinReach) {
  const Lumen l = tube(0.8);
  const Vectors unit_normals = section_normals(l.points, l.triangles);
  EXPECT_EQ(section_area(l.points, l.triangles, unit_normals, {0, 0, length / 2}, Vec3::UnitX()), 0);
  EXPECT_GT(section_area(l.points, l.triangles, unit_normals, {0, 0, length / 2}, Vec3(1, 0, 1).normalized()), 0);
}

TEST(Sections, AreaOfATube) {
  const Lumen l = tube(0.3);
  EXPECT_NEAR(throat(l, l.points), pi * 0.75 * 0.75, 0.03);
}

TEST(Deployment, AFoldedBalloonEndsWhereTheCrimpedOneDoes) {
  const Lumen l = tube(0.8);
  Scene scene = scene_with({predilatation});
  const DeploymentResult crimped = deploy(scene, l, axis());
  scene.balloons["pre"].folding = FoldingSpec{};
  const DeploymentResult folded = deploy(scene, l, axis());
  EXPECT_GT(folded.stages[0].result.steps, 2 * crimped.stages[0].result.steps) << "it has unfolded";
  EXPECT_NE(folded.switched_off, crimped.switched_off);
  EXPECT_NEAR(throat(l, folded.points), throat(l, crimped.points), 0.01 * throat(l, crimped.points));
  scene.balloons["pre"].folding->shaft_diameter = 0.75;
  EXPECT_THROW(deploy(scene, l, axis()), common::InputError) << "its profile is full of shaft";
}

} // namespace
