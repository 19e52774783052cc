#include "fill_hole.hpp"
#include "repair.hpp"
#include "tube.hpp"
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/boost/graph/helpers.h>
#include <gtest/gtest.h>

using namespace anatomy;
namespace PMP = CGAL::Polygon_mesh_processing;

namespace {

// An open tube along `axis` whose wall is rough, but whose rims are plane to rounding.
Mesh open_tube(double edge, const Vec3& axis) {
  shapes::Tube tube = shapes::straight(1.5, 4);
  tube.edge = edge;
  tube.capped = false;
  Soup soup = shapes::soup_of(tube);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.05);
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitX(), axis);
  for (Point& p : soup.points) {
    const double factor = 1 + noise(random) / 1.5;
    p = point(turn * Vec3(p.x(), factor * p.y(), factor * p.z()));
  }
  std::vector<Repair> repairs;
  return repaired(soup, repairs);
}

TEST(Filled, ClosesAHoleLargeOrSmall) {
  for (double edge : {0.2, 0.035}) { // the second: more edges than are searched among all triangles
    Mesh mesh = open_tube(edge, Vec3::UnitX());
    for (const Loop& loop : boundary_loops(mesh))
      EXPECT_EQ(filled(mesh, loop.halfedge).size(), loop.halfedges - 2);
    EXPECT_TRUE(CGAL::is_closed(mesh));
  }
}

TEST(Capped, ClosesAPlaneLoopByAFlatCap) {
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(0.6, -0.8, 0), Vec3(-0.5, 0.7, 0.1)})
    for (double edge : {0.4, 0.1, 0.035}) { // the last: more edges than are searched among all triangles
      Mesh mesh = open_tube(edge, axis.normalized());
      for (const Loop& loop : boundary_loops(mesh)) {
        const std::vector<Face> cap = capped(mesh, loop);
        ASSERT_FALSE(cap.empty());
        EXPECT_NEAR(PMP::area(cap, mesh), loop.area, 1e-9 * loop.area); // flat, and nothing folded
        EXPECT_GT(cap.size(), loop.halfedges - 2);                      // refined
      }
      EXPECT_TRUE(CGAL::is_closed(mesh));
      EXPECT_FALSE(PMP::does_self_intersect(mesh));
    }
}

} // namespace
