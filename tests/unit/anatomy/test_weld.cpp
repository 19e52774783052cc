#include "repair/weld.hpp"
#include "tube.hpp"
#include <gtest/gtest.h>

using namespace anatomy;

namespace {

Soup triangle_soup(const Soup& shared) { // each triangle with corners of its own
  Soup soup;
  for (const Triangle& t : shared.triangles) {
    for (std::size_t k : t)
      soup.points.push_back(shared.points[k]);
    const std::size_t n = soup.points.size();
    soup.triangles.push_back({n - 3, n - 2, n - 1});
  }
  return soup;
}

TEST(Weld, JoinsTheCornersOfASoup) {
  const Soup good = shapes::soup_of(shapes::straight(1.5, 10));
  std::vector<Repair> repairs;
  const Soup out = welded(triangle_soup(good), 1e-6, repairs);
  EXPECT_EQ(out.points.size(), good.points.size());
  EXPECT_EQ(out.triangles.size(), good.triangles.size());
  ASSERT_EQ(repairs.size(), 1u);
  EXPECT_EQ(repairs[0].count, 3 * good.triangles.size() - good.points.size());
}

TEST(Weld, LeavesGoodPointsAlone) {
  const Soup good = shapes::soup_of(shapes::straight(1.5, 10));
  std::vector<Repair> repairs;
  EXPECT_EQ(welded(good, 1e-6, repairs).points.size(), good.points.size());
  EXPECT_TRUE(repairs.empty());
}

TEST(Weld, JoinsGapsOfTheTolerance) {
  Soup soup = triangle_soup(shapes::soup_of(shapes::straight(1.5, 10)));
  const std::size_t n = shapes::soup_of(shapes::straight(1.5, 10)).points.size();
  for (std::size_t i = 0; i < soup.points.size(); i += 2)
    soup.points[i] = Point(soup.points[i].x() + 2e-6, soup.points[i].y(), soup.points[i].z());
  std::vector<Repair> repairs;
  EXPECT_EQ(welded(soup, 1e-5, repairs).points.size(), n);
}

TEST(Weld, DropsDuplicateAndDegenerateTriangles) {
  Soup soup = shapes::soup_of(shapes::straight(1.5, 10));
  const std::size_t n = soup.triangles.size();
  soup.region.assign(n, 0);
  soup.triangles.push_back({soup.triangles[3][1], soup.triangles[3][0], soup.triangles[3][2]}); // also turned over
  soup.triangles.push_back({5, 5, 7});
  soup.region.resize(n + 2, 9);
  std::vector<Repair> repairs;
  drop_degenerate_and_duplicate(soup, repairs);
  EXPECT_EQ(soup.triangles.size(), n);
  EXPECT_EQ(soup.region, std::vector<int>(n, 0));
  EXPECT_TRUE(shapes::reported(repairs, "degenerate triangles dropped"));
  EXPECT_TRUE(shapes::reported(repairs, "duplicate triangles dropped"));
}

TEST(Weld, DropsFinsAndNothingElse) {
  Soup soup = shapes::soup_of(shapes::straight(1.5, 10));
  const auto good = soup.triangles;
  soup.points.emplace_back(5, 3, 0);
  soup.triangles.push_back({soup.triangles[100][0], soup.triangles[100][1], soup.points.size() - 1});
  std::vector<Repair> repairs;
  drop_fins(soup, repairs);
  EXPECT_EQ(soup.triangles, good);
  ASSERT_EQ(repairs.size(), 1u);
  EXPECT_EQ(repairs[0].count, 1u);
}

TEST(Weld, KeepsTheFreeEdgesOfAnOpenTube) {
  shapes::Tube tube = shapes::straight(1.5, 10);
  tube.capped = false;
  Soup soup = shapes::soup_of(tube);
  const std::size_t n = soup.triangles.size();
  std::vector<Repair> repairs;
  drop_fins(soup, repairs);
  EXPECT_EQ(soup.triangles.size(), n);
}

} // namespace
