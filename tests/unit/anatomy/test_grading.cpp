#include "ends/ends.hpp"
#include "remesh/angle_optimiser.hpp"
#include "remesh/grading.hpp"
#include "remesh/remesh.hpp"
#include "tube_mesh.hpp"
#include <gtest/gtest.h>
#include <random>

using namespace anatomy;

namespace {

Branch straight_branch(double radius, double length) {
  Branch branch;
  for (double s = 0; s <= length; s += 0.5) {
    branch.s.push_back(s);
    branch.x.emplace_back(s, 0, 0);
    branch.radius.push_back(radius);
  }
  return branch;
}

TEST(SizingField, FollowsNarrowingThinnessAndDistance) {
  Branch branch = straight_branch(1.6, 20);
  branch.radius[20] = 0.8; // at s = 10: half the reference
  const SizingField field(0.4, {branch}, {{3.2, 0, {}}});
  EXPECT_DOUBLE_EQ(field.at({0, 1.6, 0}), 0.4);
  EXPECT_DOUBLE_EQ(field.at({10, 0.8, 0}), 0.2);
  EXPECT_NEAR(field.at({10, 1.1, 0}), 0.2 + 0.3 * 0.3, 1e-12);
  const SizingField thin(0.4, {straight_branch(0.5, 20)}, {{1.0, 0, {}}});
  EXPECT_DOUBLE_EQ(thin.at({10, 0.5, 0}), 0.3 * 0.5);
  const SizingField thinnest(0.4, {straight_branch(0.2, 20)}, {{0.4, 0, {}}});
  EXPECT_DOUBLE_EQ(thinnest.at({10, 0.2, 0}), 0.3 * 0.4);
  const SizingField thread(0.4, {straight_branch(0.1, 20)}, {{3.2, 0, {}}});
  EXPECT_DOUBLE_EQ(thread.at({10, 0.1, 0}), 0.8 * 0.1); // eight edges round it
}

TEST(Angles, AreWidenedOnTheWall) {
  const Mesh surface = shapes::mesh_of(shapes::straight(1.5, 8));
  Mesh mesh = remeshed(surface, 0.4, surface);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> shift(-0.12, 0.12);
  const WallTree wall(surface);
  for (Vertex v : mesh.vertices()) {
    const Vec3 p = vec(mesh.point(v));
    if (p.x() > 2 && p.x() < 6)
      mesh.point(v) = wall.nearest(point(p + Vec3(shift(random), shift(random), shift(random))));
  }
  const double before = quality_of(mesh).min_angle_deg, rim = quality_of(mesh).min_angle_rim_deg;
  ASSERT_LT(before, 20);
  widen_angles(mesh, surface, wall, 30);
  EXPECT_GE(quality_of(mesh).min_angle_deg, 30);
  EXPECT_GE(quality_of(mesh).min_angle_rim_deg, std::min(rim, 30.0));
  EXPECT_NO_THROW(check_remeshed(mesh, 0.4));
  const RegionMap region = region_map(mesh);
  for (Face f : mesh.faces())
    if (region[f] == 0) {
      for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
        EXPECT_LT(wall.distance(vec(mesh.point(v))), 1e-9);
    }
  EXPECT_EQ(measure_ends(mesh).size(), 2u);
}

TEST(Regraded, KeepsWhatIsAsWantedToTheBit) {
  const Mesh surface = shapes::mesh_of(shapes::straight(1.5, 8));
  const SizingField field(0.4, {straight_branch(1.5, 8)}, {{3.0, 0, {}}});
  const Mesh mesh = graded(remeshed(surface, 0.4, surface), surface, field);
  const auto again = regraded(mesh, surface, field);
  ASSERT_TRUE(again);
  ASSERT_EQ(again->number_of_vertices(), mesh.number_of_vertices());
  for (Vertex v : mesh.vertices())
    EXPECT_EQ(again->point(v), mesh.point(v));
  const SizingField finer(0.2, {straight_branch(1.5, 8)}, {{3.0, 0, {}}});
  EXPECT_FALSE(regraded(mesh, surface, finer)); // another mesh altogether
}

TEST(Coarsened, BringsAFineMeshToTheWantedEdge) {
  const Mesh surface = shapes::mesh_of(shapes::straight(1.5, 8));
  const SizingField field(0.4, {straight_branch(1.5, 8)}, {{3.0, 0, {}}});
  const std::size_t wanted = remeshed(surface, 0.4, surface).number_of_faces();
  const Mesh mesh = coarsened(remeshed(surface, 0.1, surface), 0.1, surface, field);
  // CGAL collapses no edge above 0.8 of its target. So the mesh of the level before the last stays, with edges of 0.85
  // of the wanted length and 1 / 0.85^2 = 1.38 times as many triangles. The measured ratio is 1.41.
  EXPECT_GT(static_cast<double>(mesh.number_of_faces()), 0.9 * static_cast<double>(wanted));
  EXPECT_LT(static_cast<double>(mesh.number_of_faces()), 1.45 * static_cast<double>(wanted));
  EXPECT_GE(quality_of(mesh).min_angle_deg, 30);
  EXPECT_NEAR(quality_of(mesh).volume_mm3, quality_of(surface).volume_mm3, 0.02 * quality_of(surface).volume_mm3);
  Mesh copy = mesh;
  EXPECT_EQ(measure_ends(copy).size(), 2u);
}

} // namespace
