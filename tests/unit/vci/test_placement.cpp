// A device that leaves a stent through its side: the window in the stent, and the rim of vertices around it.
#include "vci/procedure/placement.hpp"
#include <algorithm>
#include <gtest/gtest.h>

namespace {

using namespace vci;

/// A device of 20 rings along z from -5 to 5 mm, turned about x by an angle (rad).
DeviceLayout device_layout(double radius, double turn) {
  DeviceLayout layout{{20, {}, {}, {}}, {}, radius};
  const Vec3 along(0, -std::sin(turn), std::cos(turn)), across(0, std::cos(turn), std::sin(turn));
  for (int r = 0; r < 20; ++r) {
    layout.grid.s.push_back(-5 + 10.0 * r / 19);
    layout.grid.profile.push_back(1);
    layout.frames.push_back({layout.grid.s[r] * along, along, Vec3::UnitX(), across});
  }
  return layout;
}

ContactScope scope_for_turn(double turn) {
  System system;
  const DeviceLayout stent = device_layout(1.5, 0);
  const Vectors points = place_grid(stent.grid, stent.frames, std::vector<double>(20, 1.5));
  system.add_body("stent", points, stent.grid.triangles(), 1, std::vector<char>(points.size(), 0));
  return exclude_side_exit(system, {0, stent.grid, "stent"}, device_layout(1.0, turn));
}

TEST(Placement, ADeviceAlongTheStentNeedsNoWindow) {
  EXPECT_TRUE(scope_for_turn(0).outer_excluded.empty());
  EXPECT_TRUE(scope_for_turn(0).outer_rim.empty());
}

TEST(Placement, TheRimIsEveryVertexNextToTheWindowAndNoneOfIt) {
  const ContactScope found = scope_for_turn(1);
  const std::vector<char>&window = found.outer_excluded, &rim = found.outer_rim;
  ASSERT_EQ(rim.size(), window.size());
  EXPECT_GT(std::count(window.begin(), window.end(), 1), 10);
  std::vector<char> next_to(window.size(), 0);
  for (const Triangle& t : device_layout(1.5, 0).grid.triangles())
    for (int a : t)
      for (int b : t)
        next_to[a] |= window[b];
  for (std::size_t v = 0; v < window.size(); ++v)
    EXPECT_EQ(rim[v], next_to[v] && !window[v]) << v;
}

} // namespace
