// Which part of the wall a procedure moves.
#include "tests/unit/vci/vessel.hpp"
#include "vci/procedure/region.hpp"
#include <gtest/gtest.h>

namespace {

using namespace vci;
using vci::tests::Vessel;

TEST(Region, TheFarWallsOfAFlatLumenMoveLikeTheNearOnes) {
  Vessel vessel;
  vessel.length = 40, vessel.rows = 96, vessel.radius = 3, vessel.narrowing = 0;
  Lumen slit = vessel.lumen();
  for (Vec3& p : slit.points)
    p[0] /= 6;
  for (double& r : slit.radius)
    r /= 6;
  Scene scene;
  scene.balloons["balloon"] = {3, 8, 1, 0.8, 14, {2, 14}, {2.5, 2.9}};
  scene.procedure = {{"one", Action::predilatation, {{"balloon", "main", 20, 11}}}};
  const double reach = 4 + 1 + scene.numerics.region_margin;
  const std::vector<char> free = region_of_interest(slit, scene, {{"main", vessel.axis()}});
  for (std::size_t v = 0; v < free.size(); ++v) {
    const double away = std::abs(slit.points[v][2] - 20);
    if (away < reach - 1e-9) {
      EXPECT_TRUE(free[v]) << slit.points[v].transpose();
    } else if (away > reach + 2) {
      EXPECT_FALSE(free[v]) << slit.points[v].transpose();
    }
  }
}

TEST(Region, WallsOfOtherBranchesBesideADeviceMoveToo) {
  Vessel main, side;
  main.length = 60, main.rows = 144, main.narrowing = 0;
  side = main;
  side.radius = 0.5;
  Lumen lumen = main.lumen();
  const int first = static_cast<int>(lumen.points.size());
  const Lumen beside = side.lumen(); // 1 mm of tissue between the two
  for (std::size_t v = 0; v < beside.points.size(); ++v) {
    lumen.points.push_back(beside.points[v] + Vec3(3, 0, 0));
    lumen.radius.push_back(0.5);
  }
  for (const Triangle& t : beside.triangles)
    lumen.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  Scene scene;
  scene.balloons["balloon"] = {3, 8, 1, 0.8, 14, {2, 14}, {2.5, 2.9}};
  scene.procedure = {{"one", Action::predilatation, {{"balloon", "main", 30, 11}}}};
  const Path axis = main.axis(), axis_beside({Vec3(3, 0, 0), Vec3(3, 0, 30), Vec3(3, 0, 60)}, 0);
  const std::vector<char> free = region_of_interest(lumen, scene, {{"main", axis}, {"side1", axis_beside}});
  for (std::size_t v = first; v < free.size(); ++v) {
    const double away = std::abs(lumen.points[v][2] - 30);
    if (away < 5) {
      EXPECT_TRUE(free[v]) << "beside the balloon: " << lumen.points[v].transpose();
    } else if (away > 5 + 1.5 + scene.numerics.region_margin) {
      EXPECT_FALSE(free[v]) << lumen.points[v].transpose();
    }
  }
}

TEST(Region, WallsOfASharedStretchBelongToBothBranches) {
  const Path main({Vec3(0, 0, 0), Vec3(0, 0, 20), Vec3(0, 0, 40)}, 0);
  const Path side({Vec3(0, 0.05, 0), Vec3(0, 0, 20), Vec3(0, 15, 35)}, -20); // leaves the main one at 20 mm
  const Vectors wall{Vec3(1.5, 0, 10), Vec3(0, -1.5, 30), Vec3(1, 10, 30), Vec3(0, 2, 20)};
  const std::map<std::string, Path> paths{{"main", main}, {"side1", side}};
  EXPECT_EQ(points_beside(wall, paths, "main", 0, 40), (std::vector<char>{1, 1, 0, 0}));
  EXPECT_EQ(points_beside(wall, paths, "side1", -20, 20), (std::vector<char>{1, 0, 1, 1}));
  EXPECT_EQ(points_beside(wall, paths, "main", 20, 40), (std::vector<char>{0, 1, 0, 0}));
}

} // namespace
