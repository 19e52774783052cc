#include "core/crossings.hpp"
#include "core/measures.hpp"
#include "repair/fill_hole.hpp"
#include "repair/repair.hpp"
#include "tube.hpp"
#include <CGAL/boost/graph/helpers.h>
#include <gtest/gtest.h>

using namespace anatomy;

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
  for (double edge : {0.2, 0.035}) { // the second hole has too many edges to be filled in one part
    Mesh mesh = open_tube(edge, Vec3::UnitX());
    for (const Loop& loop : boundary_loops(mesh))
      EXPECT_EQ(fill_hole(mesh, loop.halfedge).size(), loop.halfedges - 2);
    EXPECT_TRUE(CGAL::is_closed(mesh));
  }
}

TEST(Capped, ClosesAPlaneLoopByAFlatCap) {
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(0.6, -0.8, 0), Vec3(-0.5, 0.7, 0.1)})
    for (double edge : {0.4, 0.1, 0.035}) { // the last hole has too many edges to be filled in one part
      Mesh mesh = open_tube(edge, axis.normalized());
      for (const Loop& loop : boundary_loops(mesh)) {
        const std::vector<Face> cap = cap_loop(mesh, loop);
        ASSERT_FALSE(cap.empty());
        EXPECT_NEAR(surface_area(mesh, cap), loop.area, 1e-9 * loop.area); // flat, and nothing folded
        EXPECT_GT(cap.size(), loop.halfedges - 2);                         // refined
      }
      EXPECT_TRUE(CGAL::is_closed(mesh));
      EXPECT_FALSE(crosses_itself(mesh));
    }
}

// Allocates and frees scattered memory, so that what is built next lies at other addresses.
std::vector<std::vector<char>> strewn(unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::vector<char>> blocks;
  for (int i = 0; i < 4000; ++i)
    blocks.emplace_back(16u << random() % 11);
  std::shuffle(blocks.begin(), blocks.end(), random);
  blocks.resize(blocks.size() / 2);
  return blocks;
}

std::vector<Triangle> corners(const Mesh& mesh) {
  std::vector<Triangle> all;
  for (Face f : mesh.faces()) {
    Triangle t;
    std::size_t k = 0;
    for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
      t[k++] = v;
    all.push_back(t);
  }
  return all;
}

TEST(Filled, IsTheSameWhereverItsSearchLiesInMemory) {
  for (double edge : {0.2, 0.035}) {
    const Mesh open = open_tube(edge, Vec3(-0.5, 0.7, 0.1).normalized()); // plane to rounding: many equal fillings
    std::vector<Triangle> first;
    for (unsigned seed = 0; seed < 8; ++seed) {
      const auto blocks = strewn(seed);
      Mesh mesh = open;
      for (const Loop& loop : boundary_loops(mesh))
        fill_hole(mesh, loop.halfedge);
      if (seed == 0)
        first = corners(mesh);
      EXPECT_EQ(corners(mesh), first) << "edge " << edge << ", seed " << seed;
    }
  }
}

TEST(SelfIntersections, AreRemovedTheSameWayWhereverTheSearchLiesInMemory) {
  shapes::Tube tube = shapes::straight(1.5, 6);
  tube.edge = 0.1;
  Soup soup = shapes::soup_of(tube);
  // the fan of a cap goes through the wall; its repair leaves a plane hole
  soup.points[soup.points.size() - 1] = Point(6, 2.5, 0);
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitX(), Vec3(-0.5, 0.7, 0.1));
  for (Point& p : soup.points)
    p = point(turn * vec(p)); // to rounding: many equal fillings
  std::vector<Repair> repairs;
  const Mesh damaged = repaired(soup, repairs);
  std::vector<Triangle> first;
  for (unsigned seed = 0; seed < 8; ++seed) {
    const auto blocks = strewn(seed);
    Mesh mesh = damaged;
    remove_self_intersections(mesh, repairs);
    if (seed == 0)
      first = corners(mesh);
    EXPECT_EQ(corners(mesh), first) << "seed " << seed;
  }
}

} // namespace
