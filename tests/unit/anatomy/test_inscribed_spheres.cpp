#include "centreline/inscribed_spheres.hpp"
#include "centreline/voronoi.hpp"
#include "common/error.hpp"
#include "tube_mesh.hpp"
#include <gtest/gtest.h>
#include <random>

using namespace anatomy;

namespace {

// Spheres along x, each linked to the next, of which the first fills the end at the origin.
InscribedSpheres in_a_row(int n) {
  InscribedSpheres spheres;
  for (int i = 0; i < n; ++i) {
    spheres.centre.emplace_back(0.1 + 0.5 * i, 0, 0);
    spheres.radius.push_back(1);
    spheres.neighbours.emplace_back();
    if (i > 0) {
      spheres.neighbours[static_cast<std::size_t>(i)].push_back(static_cast<std::size_t>(i) - 1);
      spheres.neighbours[static_cast<std::size_t>(i) - 1].push_back(static_cast<std::size_t>(i));
    }
  }
  return spheres;
}

End end_at_origin() {
  End end;
  end.normal = Vec3(-1, 0, 0);
  end.area = pi;
  return end;
}

TEST(InscribedSpheres, ASphereBesideACapThatLeadsNowhereIsNotItsSphere) {
  InscribedSpheres spheres = in_a_row(8);
  for (const Vec3& alone : {Vec3(0.01, 0, 0), Vec3(0.02, 0, 0)}) {
    spheres.centre.push_back(alone);
    spheres.radius.push_back(1);
    spheres.neighbours.emplace_back();
  }
  spheres.neighbours[8].push_back(9); // these two are neighbours of each other and of no other sphere
  spheres.neighbours[9].push_back(8);
  EXPECT_EQ(sphere_at_end(spheres, end_at_origin()), 0u);
}

TEST(InscribedSpheres, AnEndWithNothingButSuchSpheresHasNoAxis) {
  EXPECT_THROW(sphere_at_end(in_a_row(2), end_at_origin()), common::ComputationError);
}

// The points of a rim lie on one circle, so rounding decides which tetrahedra they form. So the tube is tried in many
// orientations.
TEST(InscribedSpheres, EveryTurnOfATubeHasAWayThroughIt) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const Mesh tube = shapes::mesh_of(shapes::straight(1, 8));
  for (int k = 0; k < 100; ++k) {
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
    Mesh mesh = tube;
    for (Vertex v : mesh.vertices())
      mesh.point(v) = point(turn * vec(mesh.point(v)));
    const std::vector<End> ends = measure_ends(mesh);
    ASSERT_EQ(ends.size(), 2u);
    EXPECT_NO_THROW(voronoi_paths(mesh, ends, 0)) << k;
  }
}

} // namespace
