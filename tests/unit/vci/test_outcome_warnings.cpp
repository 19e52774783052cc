// Warnings after a procedure: small stents, stents off the wall, a folded wall, deep penetration. Each limit is tested
// from both sides.
#include "vci/procedure/diagnostics.hpp"
#include "vci/results/readouts.hpp"

#include <gtest/gtest.h>

namespace {

nlohmann::json stents(double first, nlohmann::json second = nullptr) {
  return {{{"device", "des_3.00x18"}, {"expansion_index", first}},
          {{"device", "des_2.50x12"}, {"expansion_index", std::move(second)}}};
}

} // namespace

TEST(OutcomeWarnings, AnExpansionIndexBelowSixTenths) {
  EXPECT_TRUE(vci::warnings_of_outcome(stents(0.6), 0).empty());
  const auto found = vci::warnings_of_outcome(stents(0.599), 0);
  ASSERT_EQ(found.size(), 1U) << "a stent without a healthy area is passed over";
  EXPECT_EQ(found[0], "des_3.00x18 is under-expanded: its smallest area is 59.9 % of the healthy area, less than 60 %");
}

TEST(OutcomeWarnings, EachStentThatIsTooSmall) {
  EXPECT_EQ(vci::warnings_of_outcome(stents(0.3, 0.59), 0).size(), 2U);
  EXPECT_EQ(vci::warnings_of_outcome(stents(0.3, 0.61), 0).size(), 1U);
}

TEST(OutcomeWarnings, AGapToTheWallAboveFourTenthsOfAMillimetre) {
  EXPECT_TRUE(vci::warnings_of_outcome(stents(0.9), 0.4).empty());
  const auto found = vci::warnings_of_outcome(stents(0.9), 0.401);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0], "malapposition: a stent stands 0.401 mm off the wall, more than 0.4 mm");
}

TEST(OutcomeWarnings, AFoldedWallWithThePlaceOfItsFirstCrossing) {
  EXPECT_EQ(
      vci::crossing_warning({3, {1.5, -2, 0.25}}),
      "the wall is folded: 3 pairs of its triangles cross, first at (1.5, -2, 0.25) mm; do not trust areas and flow "
      "there");
}

TEST(OutcomeWarnings, AVertexDeeperThanTheLimitInBalance) {
  const vci::System system;
  vci::RelaxResult balance;
  balance.maximal_penetration = 0.05;
  EXPECT_FALSE(vci::penetration_warning(balance, system, 0.05, "stent / balloon-extraction"));
  balance.maximal_penetration = 0.051;
  EXPECT_EQ(vci::penetration_warning(balance, system, 0.05, "stent / balloon-extraction"),
            "stent / balloon-extraction: a vertex lies 0.051 mm deep in another surface, more than 0.05 mm");
}
