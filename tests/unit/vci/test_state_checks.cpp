// The state after a procedure: devices inside the wall, stents with a support, areas and perimeters of stents' rings.
#include "common/error.hpp"
#include "vci/procedure/diagnostics.hpp"
#include "vci/procedure/state_checks.hpp"
#include <gtest/gtest.h>

namespace {

using namespace vci;

RingGrid grid_of(double length, double radius) {
  RingGrid g;
  g.ring_size = even_edge_count(2 * pi * radius, 0.4);
  for (int k = 0; k <= 20; ++k) {
    g.s.push_back(length * (k / 20.0 - 0.5));
    g.profile.push_back(1);
    g.start_ratio.push_back(1);
  }
  return g;
}

int add_tube(System& system, const char* name, const RingGrid& grid, double radius) {
  const Vectors points = straight_grid(grid, radius);
  return system.add_body(name, points, grid.triangles(), 1e-4, std::vector<char>(points.size(), 0));
}

StentHistory stent_of(int body, const RingGrid& grid, const char* name = "s") {
  return {name, "main", 0, {body, grid, name}};
}

TEST(StateChecks, FindsTheVertexThatIsFurthestOutside) {
  System system;
  SurfaceTrees trees;
  const RingGrid wall = grid_of(16, 1.5), device = grid_of(10, 1.3);
  add_tube(system, "wall", wall, 1.5);
  add_tube(system, "stent", device, 1.3);
  EXPECT_EQ(furthest_outside(system, trees, system.x, system.body(0).triangles).vertex, -1);
  check_devices_inside(system, trees, system.x, system.body(0).triangles, "here");
  const int moved = system.body(1).first + 10 * device.ring_size + 3;
  for (const double out : {0.06, 0.5}) {
    Vec3& p = system.x[moved];
    const double r = std::hypot(p[0], p[1]);
    p = {p[0] * (1.5 + out) / r, p[1] * (1.5 + out) / r, p[2]};
    const OutsideVertex furthest = furthest_outside(system, trees, system.x, system.body(0).triangles);
    EXPECT_EQ(furthest.vertex, moved);
    EXPECT_NEAR(furthest.distance, out, 0.01) << "to the cylinder through the vertices, not to its chords";
    if (out < 0.1)
      check_devices_inside(system, trees, system.x, system.body(0).triangles, "here");
    else
      EXPECT_THROW(check_devices_inside(system, trees, system.x, system.body(0).triangles, "here"),
                   common::ComputationError);
  }
}

TEST(StateChecks, WhatLiesWithinTheWholeLumenIsNotOutsideOfAPartOfIt) {
  System system;
  SurfaceTrees trees;
  const RingGrid wall = grid_of(16, 1.5), device = grid_of(10, 1.3), whole = grid_of(16, 3.0);
  add_tube(system, "wall", wall, 1.5);
  add_tube(system, "stent", device, 1.3);
  Vec3& p = system.x[system.body(1).first + 10 * device.ring_size + 3];
  p.head<2>() *= 2.0 / 1.3; // as in the mouth of a side branch, whose wall is not among the bodies
  check_devices_inside(system, trees, straight_grid(whole, 3.0), whole.triangles(), "here");
  EXPECT_THROW(check_devices_inside(system, trees, system.x, system.body(0).triangles, "here"),
               common::ComputationError);
}

TEST(StateChecks, ADeviceThatPassesTheWallsOpenEndIsNotOutside) {
  System system;
  SurfaceTrees trees;
  add_tube(system, "wall", grid_of(8, 1.5), 1.5);
  add_tube(system, "stent", grid_of(12, 1.6), 1.6);
  for (int v = system.body(1).first; v < system.vertices(); ++v)
    if (std::abs(system.x[v][2]) < 4.01)
      system.x[v].head<2>() *= 0.5;
  EXPECT_EQ(furthest_outside(system, trees, system.x, system.body(0).triangles).vertex, -1);
}

ContactPoint contact(int inner, int outer, double force) {
  ContactPoint p{};
  p.stencil.vertex = {inner, outer, outer + 1, outer + 2};
  p.stencil.weight = {-1, 0.3, 0.3, 0.4};
  p.force = force;
  return p;
}

TEST(StateChecks, AStentIsSupportedByTheWallOrByAStentThatIs) {
  System system;
  const RingGrid wall = grid_of(30, 2), device = grid_of(8, 1);
  add_tube(system, "wall", wall, 2);
  std::vector<StentHistory> stents;
  std::vector<int> at;
  for (int k = 0; k < 3; ++k) {
    stents.push_back(stent_of(add_tube(system, "stent", device, 1), device));
    at.push_back(system.body(stents.back().stent.body).first);
  }
  using Flags = std::vector<char>;
  EXPECT_EQ(stents_supported(system, {}, {}, stents), (Flags{0, 0, 0}));
  EXPECT_EQ(stents_supported(system, {contact(at[1], at[0], 1)}, {}, stents), (Flags{0, 0, 0}))
      << "both hang free together";
  EXPECT_EQ(stents_supported(system, {contact(at[1], at[0], 1), contact(at[0], 5, 1)}, {}, stents), (Flags{1, 1, 0}));
  EXPECT_EQ(
      stents_supported(system, {contact(at[0], 5, 1), contact(at[2], at[1], 1), contact(at[1], at[0], 1)}, {}, stents),
      (Flags{1, 1, 1}));
  EXPECT_EQ(stents_supported(system, {contact(at[0], 5, 0)}, {}, stents), (Flags{0, 0, 0})) << "near, without a force";
  const Tie tie{contact(at[2], 5, 1).stencil, Vec3::Zero(), 0.1};
  EXPECT_EQ(stents_supported(system, {}, {tie}, stents), (Flags{0, 0, 1}));
}

TEST(Rings, SectionsAreTheTubesHoweverAslantItsRingsLie) {
  System system;
  const RingGrid grid = grid_of(10, 1.5);
  const int body = add_tube(system, "stent", grid, 1.5);
  for (int v = 0; v < system.vertices(); ++v)
    system.x[v][2] += 0.4 * system.x[v][0]; // each ring tilted by 22 degrees within the cylinder
  for (const double area : ring_section_areas(system, body, grid))
    EXPECT_NEAR(area, pi * 1.5 * 1.5, 1e-9);
  for (const double radius : ring_radii(system, body, grid))
    EXPECT_GT(radius, 1.55) << "its own area is an ellipse's";
}

TEST(Rings, AnOvalsPerimeterIsMoreThanItsAreaSays) {
  System system;
  const RingGrid grid = grid_of(10, 1.5);
  const int body = add_tube(system, "stent", grid, 1.5);
  for (const double d : perimeter_diameters(system, body, grid))
    EXPECT_NEAR(d, 3, 1e-9);
  for (Vec3& p : system.x)
    p = {1.3 * p[0], p[1] / 1.3, p[2]};
  // Ramanujan's circumference of an ellipse divided by pi. The perimeter of the ring's arcs differs from it a little.
  const double a = 1.5 * 1.3, b = 1.5 / 1.3, h = std::pow((a - b) / (a + b), 2);
  const double perimeter = (a + b) * (1 + 3 * h / (10 + std::sqrt(4 - 3 * h)));
  EXPECT_GT(perimeter, 3.09);
  for (const double d : perimeter_diameters(system, body, grid))
    EXPECT_NEAR(d, perimeter, 0.002 * perimeter);
  StentSpec spec{};
  spec.maximal_diameter = 3.05; // a round stent of the same area, 3 mm wide, would pass
  const auto warning = overexpansion_warning(system, stent_of(body, grid, "des"), spec, "kissing");
  ASSERT_TRUE(warning.has_value());
  EXPECT_NE(warning->find("kissing: des is opened to 3.1"), std::string::npos) << *warning;
  EXPECT_NE(warning->find("(21 of 21 rings)"), std::string::npos) << *warning;
  spec.maximal_diameter = 3.2;
  EXPECT_FALSE(overexpansion_warning(system, stent_of(body, grid, "des"), spec, "kissing").has_value());
}

} // namespace
