// Self-crossings of a surface: a blade through a sheet, a blade above it, and neighbours that share a vertex.
#include "vci/geometry/crossings.hpp"
#include <gtest/gtest.h>

namespace {

using namespace vci;

/// A flat square of two triangles, and an upright triangle (the blade) whose lower edge is at the height z (mm).
Crossings sheet_and_blade(double z) {
  const Vectors x{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.2, z}, {0.5, 0.8, z}, {0.5, 0.5, 1}};
  return self_crossings({{0, 1, 2}, {0, 2, 3}, {4, 5, 6}}, {0, 1, 2}, x);
}

TEST(Crossings, ABladeThatPassesThroughASheetCrossesItsTriangles) {
  const Crossings found = sheet_and_blade(-0.1);
  EXPECT_EQ(found.pairs, 2);
  EXPECT_EQ(found.first, Vec3(0, 0, 0));
}

TEST(Crossings, ABladeAboveTheSheetDoesNot) {
  EXPECT_EQ(sheet_and_blade(0.01).pairs, 0);
}

TEST(Crossings, OnlyThoseOfTheTrianglesAskedForAreCounted) {
  const Vectors x{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.2, -0.1}, {0.5, 0.8, -0.1}, {0.5, 0.5, 1}};
  const Triangles sheet_and_blade{{0, 1, 2}, {0, 2, 3}, {4, 5, 6}};
  EXPECT_EQ(self_crossings(sheet_and_blade, {2}, x).pairs, 2) << "the blade with what lies still";
  EXPECT_EQ(self_crossings(sheet_and_blade, {1}, x).pairs, 1);
  EXPECT_EQ(self_crossings(sheet_and_blade, {}, x).pairs, 0);
}

TEST(Crossings, NeighboursThatShareAVertexAreNotCounted) {
  const Vectors x{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0.5}};
  EXPECT_EQ(self_crossings({{0, 1, 2}, {0, 2, 3}}, {0, 1}, x).pairs, 0);
}

} // namespace
