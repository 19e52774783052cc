#include "common/error.hpp"
#include "trees/choose_tree.hpp"
#include "tube_mesh.hpp"
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/boost/graph/helpers.h>
#include <gtest/gtest.h>
#include <random>

using namespace anatomy;

namespace {

namespace PMP = CGAL::Polygon_mesh_processing;

Mesh tube_between(const Vec3& from, const Vec3& to, double radius, double edge) {
  const auto turned = [](const Vec3& p) { return Vec3(p.z(), p.x(), p.y()); }; // tubes along z have no rings
  shapes::Tube tube = shapes::straight(radius, (to - from).norm());
  const Vec3 along = turned(to - from).normalized(), start = turned(from);
  tube.axis = [=](double s) { return Vec3(start + s * along); };
  tube.tangent = [=](double) { return along; };
  tube.edge = edge;
  std::vector<Repair> repairs;
  Mesh mesh = repaired(shapes::soup_of(tube), repairs);
  orient_outward(mesh, repairs);
  for (Vertex v : mesh.vertices())
    mesh.point(v) = Point(mesh.point(v).y(), mesh.point(v).z(), mesh.point(v).x());
  return mesh;
}

// A trunk along z from -15 to 45 mm, and a coronary at each of these angles (degrees) round it at z = 0.
Mesh aorta_with(double trunk_radius, const std::vector<double>& angles, double scale = 1) {
  Mesh all = tube_between(Vec3(0.01, 0.02, -15) * scale, Vec3(0.01, 0.02, 45) * scale, trunk_radius * scale, scale);
  for (std::size_t k = 0; k < angles.size(); ++k) {
    const double a = angles[k] * pi / 180, far = trunk_radius + 25 + 5 * static_cast<double>(k);
    Mesh coronary =
        tube_between(Vec3((trunk_radius - 2.3) * std::cos(a), (trunk_radius - 2.3) * std::sin(a), 0.3) * scale,
                     Vec3(far * std::cos(a), far * std::sin(a), 0.3) * scale, 1.8 * scale, 0.5 * scale);
    Mesh both;
    EXPECT_TRUE(PMP::corefine_and_compute_union(all, coronary, both));
    all = both;
  }
  all.collect_garbage();
  // Real walls are not perfectly round. The points of a round ring would have no definite circumsphere.
  std::mt19937 random(1);
  std::uniform_real_distribution<double> off(-0.02 * scale, 0.02 * scale);
  for (Vertex v : all.vertices())
    all.point(v) = all.point(v) + Vector(off(random), off(random), off(random));
  region_map(all);
  return all;
}

TEST(Aorta, TreesAreNamedByTheirOrderRoundIt) {
  const std::vector<double> angles{-85, 40}; // right in front, left to the left and behind, seen from the arch
  const auto aorta = find_aorta(aorta_with(12, angles));
  ASSERT_TRUE(aorta && aorta->is_evident());
  EXPECT_NEAR(aorta->diameter, 24, 0.5);
  EXPECT_EQ(aorta->ends, 2u);
  ASSERT_EQ(aorta->trees.size(), 2u);
  EXPECT_EQ(aorta->trees[0].name, "left");
  EXPECT_GT(aorta->trees[0].ostium.centre.x(), 9);
  EXPECT_EQ(aorta->trees[1].name, "right");
  EXPECT_LT(aorta->trees[1].ostium.centre.y(), -11);
  for (const CoronaryTree& tree : aorta->trees) {
    EXPECT_NEAR(tree.diameter, 3.6, 0.1);
    EXPECT_LT((tree.ostium.centre).norm(), 14.5); // the first stretch
    EXPECT_GT(tree.ostium.normal.dot(tree.ostium.centre.normalized()), 0.99);
  }
}

TEST(Aorta, NamesFollowTheArch) {
  Mesh mesh = aorta_with(12, {-85, 40});
  // turns the vessel upside down: the arch stays in place, but the order of the ostia is reversed
  for (Vertex v : mesh.vertices())
    mesh.point(v) = Point(mesh.point(v).x(), -mesh.point(v).y(), -mesh.point(v).z());
  const auto aorta = find_aorta(mesh);
  ASSERT_TRUE(aorta && aorta->trees.size() == 2);
  EXPECT_EQ(aorta->trees[0].name, "left");
  EXPECT_GT(aorta->trees[0].ostium.centre.x(), 9);
}

TEST(Aorta, LeftAndRightAreNotGuessed) {
  const auto opposite = find_aorta(aorta_with(12, {-85, 92}));
  ASSERT_TRUE(opposite && opposite->trees.size() == 2);
  EXPECT_EQ(opposite->trees[0].name, "tree1");
  EXPECT_NE(opposite->unnamed_reason, "");
  std::vector<Repair> repairs;
  EXPECT_THROW(choose_tree(*opposite, {}), common::InputError);
  EXPECT_THROW(choose_tree(*opposite, {"left", {}, {}}), common::InputError);
  const CoronaryTree& second = opposite->trees[1];
  EXPECT_EQ(&choose_tree(*opposite, {"", second.ostium.centre, {}}), &second);
  EXPECT_EQ(&choose_tree(*opposite, {"tree2", {}, {}}), &second);
  const Vec3 outlet = second.offshoot.path.points.front();
  EXPECT_EQ(&choose_tree(*opposite, {"", {}, {outlet}}), &second);
}

TEST(Aorta, TheTreeIsCutOffAtItsOstium) {
  Mesh mesh = aorta_with(12, {-85, 40});
  std::vector<Repair> repairs;
  const auto aorta = find_aorta_to_cut(mesh, {}, LengthUnit::mm, repairs);
  ASSERT_TRUE(aorta);
  const CoronaryTree& right = choose_tree(*aorta, {"right", {}, {}});
  cut_tree_off_aorta(mesh, right, tree_cut_plane(mesh, right, {}), repairs);
  EXPECT_FALSE(CGAL::is_closed(mesh));
  double nearest = 1e300, farthest = 0;
  for (Vertex v : mesh.vertices()) {
    nearest = std::min(nearest, -mesh.point(v).y());
    farthest = std::max(farthest, -mesh.point(v).y());
  }
  EXPECT_GT(nearest, 11);
  EXPECT_NEAR(farthest, 37, 0.1);
  EXPECT_TRUE(shapes::reported(repairs, "coronary tree cut off at its ostium"));
}

TEST(Aorta, AnEctaticCoronaryIsNone) {
  const auto ectatic = find_aorta(aorta_with(5.5, {-85})); // 11 mm wide at both ends
  ASSERT_TRUE(ectatic);
  EXPECT_FALSE(ectatic->is_evident());
  const auto alone = find_aorta(aorta_with(12, {}));
  ASSERT_TRUE(alone);
  EXPECT_FALSE(alone->is_evident());
  EXPECT_FALSE(find_aorta(aorta_with(4, {-85})));
}

TEST(Aorta, CentimetresTakenForMillimetresAreRefused) {
  const Mesh mesh = aorta_with(12, {-85, 40}, 0.1);
  std::vector<Repair> repairs;
  try {
    find_aorta_to_cut(mesh, {}, LengthUnit::mm, repairs);
    FAIL() << "accepted";
  } catch (const common::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("declare units cm"), std::string::npos) << error.what();
  }
  EXPECT_FALSE(find_aorta_to_cut(mesh, {"", {}, {}, true}, LengthUnit::mm, repairs)); // the user's word
}

} // namespace
