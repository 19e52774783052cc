// Energy, force and stiffness of every force agree with finite differences, on each branch of its law.
#include "force_checks.hpp"
#include "vci/devices/balloon/balloon_chart.hpp"
#include "vci/devices/balloon/hoop_chart.hpp"
#include "vci/mechanics/fibre.hpp"
#include "vci/mechanics/hinge.hpp"
#include "vci/mechanics/membrane.hpp"
#include "vci/mechanics/pressure.hpp"
#include "vci/wall/foundation.hpp"
#include <cmath>
#include <gtest/gtest.h>

namespace {

using namespace vci;
using namespace force_checks;

TEST(Membrane, StiffeningWallMatchesFiniteDifferences) {
  Membrane force(sheet_triangles, sheet, {{2.0, 0.45, 3.0}, {1.0, 0.3, 10.0}});
  const Vectors x = perturbed(sheet, 0.25, 1);
  EXPECT_EQ(force.count_yielding(x), 0);
  check_gradient(force, x);
  check_hessian(force, x);
}

TEST(Membrane, YieldingPlaqueMatchesFiniteDifferences) {
  Membrane force(sheet_triangles, sheet, {{2.0, 0.45, 0.0, 0.05, 0.08}, {2.0, 0.45, 0.0, 0.05, 0.3}});
  const Vectors x = perturbed(sheet, 0.25, 2);
  EXPECT_EQ(force.count_yielding(x), 2) << "both triangles must be on the plastic branch";
  check_gradient(force, x);
  check_hessian(force, x);
}

/// Laws of wall and plaque at a depth behind the lumen. Their strain is the strain of the lumen.
std::vector<HenckyLaw> deep_laws() {
  HenckyLaw stiffens{2.0, 0.45, 3.0}, yields{2.0, 0.45, 0.0, 0.05, 0.1};
  stiffens.depth = 1.7;
  yields.depth = 2.5;
  return {stiffens, yields};
}

TEST(Membrane, LayersAtDepthMatchFiniteDifferences) {
  Membrane force(sheet_triangles, sheet, deep_laws());
  const Vectors x = perturbed(sheet, 0.3, 3);
  EXPECT_EQ(force.count_yielding(x), 1);
  check_gradient(force, x);
  check_hessian(force, x);
  force.commit(x);
  const Vectors y = perturbed(x, 0.05, 4);
  check_gradient(force, y);
  check_hessian(force, y);
}

TEST(HenckyLaw, FlowAtDepthKeepsTheStress) {
  HenckyLaw law = deep_laws()[1];
  const Vec2 strain(0.9, -0.1);
  const HenckyLaw::Response before = law.response_at((2 * strain).array().exp());
  ASSERT_TRUE(before.yields);
  const Vec2 lasting = law.flow(strain);
  const HenckyLaw::Response after = law.response_at((2 * (strain - lasting)).array().exp());
  EXPECT_NEAR(after.strain, law.yield_strain, 1e-12);
  EXPECT_LT(law.depth, 2.5);
  EXPECT_NEAR(after.stress[0], before.stress[0], 1e-12);
}

TEST(Membrane, EqualStretchesHaveTheLimitOfTheShearModulus) {
  Membrane force(sheet_triangles, sheet, {{2.0, 0.45, 3.0}, {2.0, 0.45, 3.0}});
  Vectors x = sheet;
  for (Vec3& p : x)
    p *= 1.3;
  check_hessian(force, x, 1e-5);
}

TEST(Membrane, CommitKeepsTheStressAndMakesTheStrainPermanent) {
  Membrane force(sheet_triangles, sheet, {{2.0, 0.45, 0.0, 0.05, 0.1}, {2.0, 0.45, 0.0, 0.05, 0.1}});
  Vectors x = sheet;
  for (Vec3& p : x)
    p *= 1.5;
  Vectors before(x.size(), Vec3::Zero()), after = before, back = before;
  force.evaluate(x, before, nullptr, true);
  force.commit(x);
  force.evaluate(x, after, nullptr, true);
  for (std::size_t i = 0; i < x.size(); ++i)
    EXPECT_LT((before[i] - after[i]).norm(), 1e-12);
  Vectors eased = x;
  for (Vec3& p : eased)
    p *= 0.999;
  EXPECT_EQ(force.count_yielding(eased), 0) << "unloading is elastic";
  force.evaluate(sheet, back, nullptr, true);
  EXPECT_GT(back[2].norm(), 1e-3) << "the first shape is no longer free of stress";
}

TEST(Membrane, PositivePartHasNoNegativeCurvature) {
  Membrane force(sheet_triangles, sheet, {{2.0, 0.45, 0.0}, {2.0, 0.45, 0.0}});
  Vectors x = sheet;
  for (Vec3& p : x)
    p *= 0.7; // compressed, so the stiffness out of the plane is negative
  BlockPattern pattern(4);
  pattern.add(std::array<int, 4>{0, 1, 2, 3});
  BlockMatrix exact(pattern), positive(std::move(pattern));
  Vectors f(4, Vec3::Zero()), y(4);
  const Vectors up{{0, 0, 1}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  const auto curvature = [&](BlockMatrix& m, bool is_exact) {
    force.locate_blocks(m);
    force.evaluate(x, f, &m, is_exact);
    m.multiply(up, y);
    return y[0][2];
  };
  EXPECT_LT(curvature(exact, true), 0);
  EXPECT_GE(curvature(positive, false), 0);
}

TEST(Hinges, AngleMatchesFiniteDifferences) {
  const std::vector<InteriorEdge> edges = interior_edges(sheet_triangles, sheet);
  ASSERT_EQ(edges.size(), 1u);
  Hinges force(edges, sheet, {0.7}, 1e9);
  const Vectors x = perturbed(sheet, 0.3, 3);
  EXPECT_GT(force.energy(x), 1e-3);
  check_gradient(force, x);
  check_hessian(force, sheet); // the matrix is exact only at the rest angle
}

TEST(Hinges, FoldsBeyondTheYieldAngle) {
  const std::vector<InteriorEdge> edges = interior_edges(sheet_triangles, sheet);
  Hinges force(edges, sheet, {1.0}, 0.1);
  Vectors x = sheet;
  x[3][2] += 0.8;
  EXPECT_GT(force.energy(x), 0.5 * 0.1 * 0.1);
  force.commit(x);
  EXPECT_NEAR(force.energy(x), 0.5 * 0.1 * 0.1, 1e-12);
}

TEST(Fibres, EveryBranchMatchesFiniteDifferences) {
  const Vectors x{{0, 0, 0}, {1.0, 0.2, 0.1}};
  const double l = (x[1] - x[0]).norm();
  Fibres stretched({{0, 1, l / 1.2, 3.0, 0.4}});
  Fibres pressed({{0, 1, l * 1.2, 3.0}});
  Fibres::Fibre film{0, 1, l * 1.3, 3.0};
  film.slack = true;
  film.pretension = 0.2;
  Fibres slack({film});
  Vectors f(2, Vec3::Zero());
  slack.evaluate(x, f, nullptr, true);
  EXPECT_LT(f[0].norm(), 0.1) << "the slack branch must carry next to nothing";
  for (Fibres* force : {&stretched, &pressed, &slack}) {
    check_gradient(*force, x);
    check_hessian(*force, x);
  }
}

TEST(HoopChart, EachPieceOfTheChartMatchesFiniteDifferences) {
  const BalloonChart chart({0.2, 1.0, 2.0}, {2.8, 3.0, 3.1}, 0.9);
  const int n = 24;
  HoopChart force({{0, 1, 0.4, 0.8}}, n, chart);
  const double to_edge = 0.8 / std::sqrt(n / (pi * std::tan(pi / n)));
  for (double d : {0.8, 1.5, 2.78, 2.9, 3.05, 3.3}) {
    const Vectors x{{0, 0, 0}, Vec3(0.6, 0, 0.8) * d * to_edge};
    check_gradient(force, x);
    check_hessian(force, x);
  }
}

TEST(RingFoundation, OutwardAndInwardMatchFiniteDifferences) {
  const RingLaw law{0.055, 0.02, 0.0124, 0.9, 1.6};
  const Vec3 n = Vec3(1, 2, -1).normalized();
  RingFoundation force({{0, Vec3(1, 0, 0), n, 0.1, law}});
  for (double u : {0.7, 0.1, -0.3}) {
    const Vectors x{Vec3(1, 0, 0) + u * n + 0.05 * n.unitOrthogonal()};
    check_gradient(force, x);
    check_hessian(force, x);
  }
  Vectors f(1, Vec3::Zero());
  force.evaluate({Vec3(1, 0, 0)}, f, nullptr, true);
  EXPECT_EQ(f[0].norm(), 0) << "the lumen as given is in equilibrium under mean blood pressure";
}

TEST(Anchors, MatchFiniteDifferences) {
  Anchors force({{0, Vec3(1, 2, 3), 0.7}});
  const Vectors x{{1.5, 2, 2.5}};
  check_gradient(force, x);
  check_hessian(force, x);
}

TEST(Pressure, IsTheGradientOfTheEnclosedVolume) {
  Pressure force(tetrahedron_triangles, tetrahedron, 1.3);
  EXPECT_NEAR(force.energy(tetrahedron), -1.3 / 6, 1e-14);
  const Vectors x = perturbed(tetrahedron, 0.2, 4);
  check_gradient(force, x);
  check_hessian(force, x);
}

TEST(RingFoundation, PressureTurnsWithTheSurface) {
  constexpr int around = 8;
  Vectors points;
  for (int ring = 0; ring < 3; ++ring)
    for (int k = 0; k < around; ++k)
      points.push_back({std::cos(2 * pi * k / around), std::sin(2 * pi * k / around), 0.5 * ring});
  Triangles triangles;
  for (int ring = 0; ring < 2; ++ring)
    for (int k = 0; k < around; ++k) {
      const int a = ring * around + k, b = ring * around + (k + 1) % around;
      triangles.insert(triangles.end(), {{a, b, b + around}, {a, b + around, a + around}});
    }
  std::vector<RingFoundation::Element> rings;
  for (int v = around; v < 2 * around; ++v)
    rings.push_back({v, points[v], points[v] - Vec3(0, 0, 0.5), 0.1, {0.4, 0, 0.012, 1.0, 1.2}});
  // Torque about the axis divided by the sum of the forces' magnitudes. The tube is widened by 30 % and turned by
  // 0.1 rad.
  const auto torque = [&](const RingFoundation& force) {
    Vectors x = points, f(points.size(), Vec3::Zero());
    for (Vec3& p : x)
      p = Vec3(1.3 * std::cos(0.1) * p[0] - 1.3 * std::sin(0.1) * p[1],
               1.3 * std::sin(0.1) * p[0] + 1.3 * std::cos(0.1) * p[1], p[2]);
    force.evaluate(x, f, nullptr, true);
    double about = 0, size = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      about += x[i][0] * f[i][1] - x[i][1] * f[i][0];
      size += f[i].norm();
    }
    return about / size;
  };
  EXPECT_NEAR(torque(RingFoundation(rings, triangles)), 0, 1e-12);
  EXPECT_GT(torque(RingFoundation(rings)), 0.1) << "a fixed direction turns the ring further";
}

} // namespace
