#include "measured_tube.hpp"
#include <gtest/gtest.h>

using namespace anatomy;
using shapes::Measured, shapes::measured;

namespace {

TEST(Tree, StraightTube) {
  const Measured tube = measured(shapes::straight(1.5, 20));
  ASSERT_EQ(tube.branches.size(), 1u);
  const Branch& main = tube.branches[0];
  EXPECT_EQ(main.name, "main");
  EXPECT_EQ(tube.ends[main.end].name, "outlet1");
  EXPECT_NEAR(main.axis.length(), 20, 1e-3);
  for (std::size_t i = 0; i < main.x.size(); ++i) {
    EXPECT_LT(std::hypot(main.x[i].y(), main.x[i].z()), 0.005);
    EXPECT_LT(main.curvature[i], 0.005);
    EXPECT_NEAR(main.radius[i], 1.5, 0.03);
  }
  for (const Section& section : tube.sections) {
    if (section.flag == SectionFlag::end)
      continue;
    EXPECT_EQ(section.flag, SectionFlag::ok);
    // a polygon of 24 to 48 corners in the circle has 0.989 to 0.993 of its area
    EXPECT_NEAR(section.area / (pi * 1.5 * 1.5), 0.991, 0.003);
    EXPECT_NEAR(section.min_diameter, 2.96, 0.04);
    EXPECT_NEAR(section.max_diameter, 2.99, 0.02);
  }
}

TEST(Tree, BentTubeKeepsItsCurvature) {
  for (double edge : {0.4, 0.25}) {
    shapes::Tube tube = shapes::arc(0.3, 1.5, 15);
    tube.edge = edge;
    const Branch main = measured(tube).branches.at(0);
    double sum = 0;
    int n = 0;
    for (std::size_t i = 0; i < main.s.size(); ++i)
      if (main.s[i] > 2.25 && main.s[i] < 12.75) {
        sum += main.curvature[i];
        ++n;
        EXPECT_NEAR((main.x[i] - Vec3(0, 1 / 0.3, 0)).norm(), 1 / 0.3, 0.02);
      }
    EXPECT_NEAR(sum / n, 0.3, 0.02 * 0.3) << edge;
    EXPECT_NEAR(main.axis.length(), 15, 0.05);
  }
}

TEST(Tree, EveryEndSectionIsFlagged) {
  const Measured tube = measured(shapes::straight(1.5, 12));
  for (const Section& section : tube.sections) {
    const double s = tube.branches[0].s[section.sample];
    EXPECT_EQ(section.flag == SectionFlag::end,
              s < 1.5 * tube.branches[0].radius.front() || s > 12 - 1.5 * tube.branches[0].radius.back())
        << s;
  }
}

// The straight line that continues the side branch backwards passes 0.25 mm beside the axis where the branch leaves. It
// meets the axis 6.4 mm upstream, at the other end of the chord through the bend, where the wall lies between.
TEST(Tree, ABranchOutsideABendLeavesWhereItMeetsItsParent) {
  const double leaves_at = 14, chord_back = 6.4;
  const shapes::Tube tube = shapes::arc(0.25, 1.2, 20);
  Measured out = measured(tube);
  const std::size_t inlet = inlet_of(out.ends, tube.axis(0));
  std::vector<Path> paths = voronoi_paths(out.mesh, out.ends, inlet);
  const Vec3 junction = tube.axis(leaves_at) + Vec3(0, 0, 0.25), upstream = tube.axis(leaves_at - chord_back);
  const Vec3 away = (junction - upstream).normalized();
  Path side;
  for (double s = 0.5; s < leaves_at; s += 0.1)
    side.points.push_back(tube.axis(s));
  for (double t = 0; t < 8; t += 0.1)
    side.points.push_back(junction + t * away);
  side.radius.assign(side.points.size(), 1.2);
  End end;
  end.centre = junction + 8 * away;
  end.normal = away;
  end.area = pi;
  out.ends.push_back(end);
  paths.push_back(side);
  const std::vector<int> main_then_side{0, 0, 1};
  const std::vector<Branch> branches = build_tree(paths, out.ends, inlet, WallTree(out.mesh), 0.25, main_then_side);
  ASSERT_EQ(branches.size(), 2u);
  EXPECT_NEAR(branches[1].s_on_parent, leaves_at, 0.5);
  EXPECT_NEAR(branches[1].axis.length(), 8, 0.5);
}

} // namespace
