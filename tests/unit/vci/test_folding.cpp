// Folded balloons: their sections, their layers, and how they unfold.
#include "common/error.hpp"
#include "straight_axis.hpp"
#include "vci/bench/bench.hpp"
#include "vci/devices/balloon/balloon.hpp"
#include "vci/devices/balloon/folding.hpp"
#include "vci/geometry/surface.hpp"
#include "vci/procedure/unfolding.hpp"
#include <gtest/gtest.h>
#include <set>

namespace {

using namespace vci;
using tests::straight_frames;

BalloonSpec winged_balloon(const FoldingSpec& folding, double diameter = 3.0, double length = 6.0) {
  const double d = diameter;
  return {d,      length, 1.5, 0.85, 20, {2, 6, 10, 14, 18}, {0.934 * d, 0.978 * d, 1.022 * d, 1.066 * d, 1.11 * d},
          folding};
}

Vectors folded_vertices(const BalloonSpec& spec, const RingGrid& grid) {
  return place_folded(spec, grid, straight_frames(grid),
                      std::vector<double>(grid.rings(), 0.5 * spec.crimped_diameter));
}

bool pierces(const Vec3& a, const Vec3& b, const Vec3& p, const Vec3& q, const Vec3& r) {
  const Vec3 n = (q - p).cross(r - p);
  const double da = n.dot(a - p), db = n.dot(b - p);
  if (da * db >= 0)
    return false;
  const Vec3 x = a + da / (da - db) * (b - a);
  return n.dot((q - p).cross(x - p)) > 0 && n.dot((r - q).cross(x - q)) > 0 && n.dot((p - r).cross(x - r)) > 0;
}

/// The number of pairs of an edge and a triangle that it pierces without a shared vertex.
int crossings(const Triangles& triangles, const Vectors& x) {
  std::set<std::pair<int, int>> edges;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k)
      edges.insert(std::minmax({t[k], t[(k + 1) % 3]}));
  int count = 0;
  for (const Triangle& t : triangles) {
    const auto [low, high] = std::minmax({x[t[0]][2], x[t[1]][2], x[t[2]][2]});
    for (const auto& [a, b] : edges) {
      const bool apart = std::max(x[a][2], x[b][2]) < low || std::min(x[a][2], x[b][2]) > high;
      if (!apart && std::none_of(t.begin(), t.end(), [&, i = a, j = b](int v) { return v == i || v == j; }))
        count += pierces(x[a], x[b], x[t[0]], x[t[1]], x[t[2]]);
    }
  }
  return count;
}

class Wings : public testing::TestWithParam<int> {};

TEST_P(Wings, SectionHasTheUnfoldedPerimeterAndAsManyLikeSectors) {
  for (double diameter : {2.5, 3.0})
    for (bool clockwise : {false, true}) {
      const int wings = GetParam();
      const BalloonSpec spec = winged_balloon({wings, 0.5, 0.02, clockwise}, diameter);
      const int n = balloon_grid(spec, 0.45).ring_size;
      const FoldedSection section = folded_section(spec, n);
      ASSERT_EQ(section.points.size(), static_cast<std::size_t>(n));
      const double edge = unfolded_diameter(spec) * std::sin(pi / n);
      const Eigen::Rotation2Dd turn(2 * pi / wings);
      double turned = 0;
      for (int k = 0; k < n; ++k) {
        const Vec2 &p = section.points[k], &next = section.points[(k + 1) % n];
        EXPECT_NEAR((next - p).norm(), edge, 1e-9);
        EXPECT_LT((turn * p - section.points[(k + n / wings) % n]).norm(), 1e-12);
        turned += std::atan2(p[0] * next[1] - p[1] * next[0], p.dot(next));
      }
      EXPECT_NEAR(turned, 2 * pi, 1e-9) << "once round, counterclockwise";
      EXPECT_GE(section.inner_radius, 0.25);
      EXPECT_LE(section.outer_radius, 0.425);
      EXPECT_NEAR(edge * n, pi * unfolded_diameter(spec), 0.005 * pi * unfolded_diameter(spec));
    }
}

TEST_P(Wings, StartWithoutCrossing) {
  const BalloonSpec spec = winged_balloon({GetParam(), 0.5, 0.02, false});
  const RingGrid grid = balloon_grid(spec, 0.45);
  const Triangles triangles = grid.triangles();
  Vectors x = folded_vertices(spec, grid);
  EXPECT_EQ(crossings(triangles, x), 0);
  const int middle = grid.rings() / 2 * grid.ring_size;
  for (int k = 0; k < grid.ring_size; ++k) // one ring becomes a circle inside the folds, so edges cross
    x[middle + k] =
        Vec3(0.3 * std::cos(2 * pi * k / grid.ring_size), 0.3 * std::sin(2 * pi * k / grid.ring_size), x[middle][2]);
  EXPECT_GT(crossings(triangles, x), 0) << "the check sees crossings";
}

INSTANTIATE_TEST_SUITE_P(TwoToSix, Wings, testing::Range(2, 7));

TEST(Folding, ClockwiseIsTheMirrorImage) {
  const FoldedSection one = folded_section({3, 0.5, 0.02, false}, 72, 0.12);
  const FoldedSection other = folded_section({3, 0.5, 0.02, true}, 72, 0.12);
  EXPECT_GT((one.points[20] - other.points[20]).norm(), 0.1) << "a wrapped wing is not its own mirror image";
  for (int k = 0; k < 72; ++k) {
    const Vec2& p = other.points[(72 - k) % 72];
    EXPECT_LT((one.points[k] - Vec2(p[0], -p[1])).norm(), 1e-15);
  }
}

TEST(Folding, RefusesWhatDoesNotFit) {
  const FoldingSpec folding{3, 0.5, 0.02, false};
  BalloonSpec tight = winged_balloon(folding);
  tight.crimped_diameter = 0.6;
  EXPECT_THROW(balloon_grid(tight, 0.45), common::InputError);
  EXPECT_THROW(balloon_grid(winged_balloon(folding, 0.8), 0.45), common::InputError) << "nothing left for wings";
  const BalloonSpec spec = winged_balloon(folding);
  const RingGrid grid = balloon_grid(spec, 0.45);
  EXPECT_THROW(place_folded(spec, grid, straight_frames(grid), std::vector<double>(grid.rings(), 0.3)),
               common::ComputationError);
}

TEST(BalloonChart, OfAnUnfoldedBalloonBucklesBelowItsDiameter) {
  const BalloonChart chart = BalloonChart::of_unfolded({0.2, 0.6, 1.0}, {2.8, 3.0, 3.1});
  EXPECT_NEAR(chart.diameter_at(0), 2.7, 1e-12);
  EXPECT_NEAR(chart.pressure_at(2.9), 0.4, 1e-12);
  EXPECT_NEAR(chart.slope_at(2.75), 2.0, 1e-12);
  EXPECT_NEAR(chart.slope_at(2.0), 0.04, 1e-12);
  EXPECT_LT(chart.pressure_at(2.6), 0);
  const double h = 1e-5;
  for (double d : {1.0, 2.6, 2.75, 2.95})
    EXPECT_NEAR((chart.first_moment(d + h) - chart.first_moment(d - h)) / (2 * h), chart.pressure_at(d) * d, 1e-6);
  EXPECT_THROW(BalloonChart::of_unfolded({10, 11}, {2.0, 3.0}), std::invalid_argument);
}

/// A long strip folded back over itself with a gap. If `inward` is false, the outer sides of its two layers face one
/// another, otherwise the inner sides.
struct FoldedStrip {
  System system;
  FoldedStrip(double gap, bool inward) {
    Vectors points;
    Triangles triangles;
    const int across = 12, along = 5;
    for (int r = 0; r < along; ++r)
      for (int k = 0; k < 2 * across; ++k) {
        const int from_fold = k < across ? across - k : k - across + 1;
        points.push_back({0.1 * from_fold + (k < across ? 0.05 : 0.0), (k < across ? 0.5 : -0.5) * gap, 0.1 * r});
      }
    for (int r = 0; r + 1 < along; ++r)
      for (int k = 0; k + 1 < 2 * across; ++k) {
        const int a = r * 2 * across + k, b = a + 1, c = a + 2 * across, d = c + 1;
        triangles.push_back(inward ? Triangle{a, b, d} : Triangle{a, d, b});
        triangles.push_back(inward ? Triangle{a, d, c} : Triangle{a, c, d});
      }
    system.add_body("strip", points, triangles, 1e-4, std::vector<char>(points.size(), 0));
  }
  std::vector<ContactPoint> contacts(SelfContact& contact) {
    std::vector<ContactPoint> points;
    contact.detect(system, area_vectors(system), points);
    return points;
  }
};

class Sides : public testing::TestWithParam<bool> {};

TEST_P(Sides, LayersRepelAndRememberTheirSide) {
  FoldedStrip strip(0.03, GetParam());
  const std::vector<double> thickness(strip.system.vertices(), 0.02);
  SelfContact contact(strip.system, 0, 60, thickness);
  EXPECT_TRUE(strip.contacts(contact).empty()) << "a gap beyond the thickness";
  EXPECT_GT(contact.count_facing(), 60);
  for (double gap : {0.01, -0.03}) { // pressed together, then through one another: each layer keeps its first side
    for (int v = 0; v < strip.system.vertices(); ++v)
      strip.system.x[v][1] = (v % 24 < 12 ? 0.5 : -0.5) * gap;
    const std::vector<ContactPoint> points = strip.contacts(contact);
    ASSERT_GT(points.size(), 40u);
    Vectors force(strip.system.vertices(), Vec3::Zero());
    add_contact_forces(points, force);
    Vec3 sum = Vec3::Zero();
    double upper = 0, lower = 0;
    for (int v = 0; v < strip.system.vertices(); ++v) {
      sum += force[v];
      (v % 24 < 12 ? upper : lower) += force[v][1];
    }
    EXPECT_LT(sum.norm(), 1e-12) << "momentum";
    EXPECT_GT(upper, 0.001);
    EXPECT_LT(lower, -0.001);
    for (const ContactPoint& p : points) {
      if (strip.system.x[p.stencil.vertex[0]][0] < 0.5)
        continue; // near the fold
      EXPECT_NEAR(p.gap, gap, 1e-3);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(OuterAndInner, Sides, testing::Bool());

TEST(SelfContact, OnlyTouchesWhatHasThickness) {
  FoldedStrip strip(0.01, false);
  SelfContact none(strip.system, 0, 60, std::vector<double>(strip.system.vertices(), 0.0));
  EXPECT_TRUE(strip.contacts(none).empty());
  SelfContact all(strip.system, 0, 60, std::vector<double>(strip.system.vertices(), 0.02));
  EXPECT_FALSE(strip.contacts(all).empty());
}

void expect_unfolds_and_follows_the_chart(const FoldingSpec& folding) {
  const Numerics numerics;
  const std::vector<InflationPoint> points = inflate(winged_balloon(folding), numerics, {2, 8, 18});
  ASSERT_EQ(points.size(), 3u);
  EXPECT_GT(points[0].steps, 50) << "it starts folded";
  for (const InflationPoint& p : points) {
    EXPECT_NEAR(p.diameter_mm / p.chart_diameter_mm, 1, 0.005) << p.pressure_bar;
    EXPECT_LE(p.residual, numerics.integrator.residual_tolerance);
  }
}

TEST(Inflation, ThreeWingsUnfoldAndFollowTheChart) {
  expect_unfolds_and_follows_the_chart({3, 0.5, 0.02, false});
}

TEST(Inflation, TwoWingsWrappedClockwiseUnfoldAndFollowTheChart) {
  expect_unfolds_and_follows_the_chart({2, 0.5, 0.02, true});
}

/// A folded balloon after its inflation in air.
struct Unfolded {
  RingGrid grid;
  Vectors x;
};
Unfolded unfold(const BalloonSpec& spec, double pressure_bar) {
  const Numerics numerics;
  System system;
  const RingGrid grid = balloon_grid(spec, 0.45);
  Balloon b = add_balloon(system, spec, grid, straight_frames(grid), std::vector<double>(grid.rings(), 0.425));
  Interactions layers;
  add_layer_contacts(layers, system, b, spec, numerics.contact);
  set_pressure(b, pressure_bar * mpa_per_bar);
  EXPECT_TRUE(relax(system, layers, folded_balloon_settings(numerics.integrator, spec, true)).converged);
  return {grid, system.x};
}

TEST(Inflation, WingsUnfoldAlikeWithoutCrossingAndTwiceTheSame) {
  const BalloonSpec spec = winged_balloon({3, 0.5, 0.02, false}, 3.0, 4.0);
  const Unfolded u = unfold(spec, 8);
  const int n = u.grid.ring_size;
  Triangles body; // without the necks, whose folds have no contact with one another
  for (const Triangle& t : u.grid.triangles())
    if (std::all_of(t.begin(), t.end(), [&](int v) { return u.grid.profile[v / n] >= 0.6; }))
      body.push_back(t);
  EXPECT_EQ(crossings(body, u.x), 0);
  for (int r = 0; r < u.grid.rings(); ++r)
    if (u.grid.profile[r] == 1) {
      Vec3 centre = Vec3::Zero();
      for (int k = 0; k < n; ++k)
        centre += u.x[r * n + k] / n;
      for (int k = 0; k < n; ++k)
        EXPECT_NEAR((u.x[r * n + k] - centre).norm(), (u.x[r * n + (k + n / 3) % n] - centre).norm(), 0.05) << r;
    }
  EXPECT_TRUE(unfold(spec, 8).x == u.x);
}

} // namespace
