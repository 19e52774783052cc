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

} // namespace
