#include "common/error.hpp"
#include "core/measures.hpp"
#include "repair/loops.hpp"
#include "repair/repair.hpp"
#include "tube.hpp"
#include <CGAL/boost/graph/helpers.h>
#include <gtest/gtest.h>

using namespace anatomy;

namespace {

Soup good_tube() {
  return shapes::soup_of(shapes::straight(1.5, 10));
}

// Index of a wall triangle in the middle of the tube.
std::size_t middle_triangle(const Soup& soup) {
  for (std::size_t i = 0; i < soup.triangles.size(); ++i)
    if (std::abs(soup.points[soup.triangles[i][0]].x() - 5) < 0.3)
      return i;
  return 0;
}

TEST(Repair, LeavesAGoodSurfaceAlone) {
  std::vector<Repair> repairs;
  const Mesh mesh = repaired(good_tube(), repairs);
  EXPECT_TRUE(repairs.empty());
  EXPECT_TRUE(CGAL::is_closed(mesh));
  EXPECT_EQ(mesh.number_of_faces(), good_tube().triangles.size());
}

TEST(Repair, TurnsFlippedTriangles) {
  Soup soup = good_tube();
  for (std::size_t i = 0; i < soup.triangles.size(); i += 3)
    std::swap(soup.triangles[i][0], soup.triangles[i][1]);
  std::vector<Repair> repairs;
  Mesh mesh = repaired(soup, repairs);
  ASSERT_TRUE(shapes::reported(repairs, "triangles turned"));
  EXPECT_EQ(repairs[0].count, (soup.triangles.size() + 2) / 3);
  orient_outward(mesh, repairs);
  EXPECT_GT(enclosed_volume(mesh), 60);
}

TEST(Repair, TurnsAnInwardSurfaceOutward) {
  Soup soup = good_tube();
  for (Triangle& t : soup.triangles)
    std::swap(t[0], t[1]);
  std::vector<Repair> repairs;
  Mesh mesh = repaired(soup, repairs);
  orient_outward(mesh, repairs);
  EXPECT_TRUE(shapes::reported(repairs, "normals turned outward"));
  EXPECT_GT(enclosed_volume(mesh), 60);
}

TEST(Repair, FillsAHoleInTheWallButNotAnEnd) {
  shapes::Tube tube = shapes::straight(1.5, 10);
  tube.capped = false;
  Soup soup = shapes::soup_of(tube);
  const std::size_t n = soup.triangles.size();
  const auto at = static_cast<long>(middle_triangle(soup));
  soup.triangles.erase(soup.triangles.begin() + at, soup.triangles.begin() + at + 2);
  std::vector<Repair> repairs;
  const Mesh mesh = repaired(soup, repairs);
  EXPECT_TRUE(shapes::reported(repairs, "hole filled"));
  EXPECT_EQ(mesh.number_of_faces(), n);
  EXPECT_EQ(boundary_loops(mesh).size(), 2u);
}

TEST(Repair, KeepsTheLargestComponent) {
  Soup soup = good_tube();
  const Soup small = shapes::soup_of(shapes::straight(0.5, 2));
  const std::size_t n = soup.points.size();
  for (const Point& p : small.points)
    soup.points.emplace_back(p.x(), p.y() + 8, p.z());
  for (const Triangle& t : small.triangles)
    soup.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  std::vector<Repair> repairs;
  EXPECT_EQ(repaired(soup, repairs).number_of_faces(), good_tube().triangles.size());
  EXPECT_TRUE(shapes::reported(repairs, "components dropped"));
}

TEST(Repair, RemovesASelfIntersection) {
  Soup soup = good_tube();
  // one vertex of the wall pushed through the opposite wall
  const std::size_t v = soup.triangles[middle_triangle(soup)][0];
  const Point p = soup.points[v];
  soup.points[v] = Point(p.x(), -1.3 * p.y(), -1.3 * p.z());
  std::vector<Repair> repairs;
  Mesh mesh = repaired(soup, repairs);
  remove_self_intersections(mesh, repairs);
  EXPECT_TRUE(shapes::reported(repairs, "self-intersections removed"));
  EXPECT_TRUE(CGAL::is_closed(mesh));
  std::vector<Repair> again;
  remove_self_intersections(mesh, again);
  EXPECT_TRUE(again.empty());
}

TEST(Repair, RefusesWhatHasNoSurface) {
  Soup soup;
  soup.points = {Point(0, 0, 0), Point(1, 0, 0), Point(0, 1, 0)};
  soup.triangles.assign(6, {0, 1, 2});
  std::vector<Repair> repairs;
  EXPECT_THROW(repaired(soup, repairs), common::InputError);
}

} // namespace
