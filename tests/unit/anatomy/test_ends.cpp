#include "app/checks.hpp"
#include "common/error.hpp"
#include "ends/cap_open_ends.hpp"
#include "ends/ends.hpp"
#include "ends/ragged_ends.hpp"
#include "remesh/remesh.hpp"
#include "repair/repair.hpp"
#include "trees/naming.hpp"
#include "tube_mesh.hpp"
#include <CGAL/boost/graph/helpers.h>
#include <gtest/gtest.h>

using namespace anatomy;

namespace {

// A cone from radius 1.6 at x = 0 to 1.2 at x = 12.
Mesh cone(bool capped, double edge = 0.4) {
  shapes::Tube tube = shapes::straight(1.6, 12);
  tube.radius = [](double s) { return 1.6 - s / 30; };
  tube.capped = capped;
  tube.edge = edge;
  std::vector<Repair> repairs;
  Mesh mesh = repaired(shapes::soup_of(tube), repairs);
  region_map(mesh);
  return mesh;
}

void expect_the_cones_ends(const std::vector<End>& ends) {
  ASSERT_EQ(ends.size(), 2u);
  EXPECT_NEAR(ends[0].radius(), 1.6, 0.03); // chords of the rim
  EXPECT_NEAR(ends[1].radius(), 1.2, 0.03);
  EXPECT_NEAR((ends[0].centre - Vec3(0, 0, 0)).norm(), 0, 0.005);
  EXPECT_NEAR((ends[0].normal - Vec3(-1, 0, 0)).norm(), 0, 1e-6);
  EXPECT_NEAR((ends[1].centre - Vec3(12, 0, 0)).norm(), 0, 0.005);
  EXPECT_NEAR((ends[1].normal - Vec3(1, 0, 0)).norm(), 0, 1e-6);
}

TEST(Ends, OpenEndsAreCapped) {
  Mesh mesh = cone(false);
  std::vector<Repair> repairs;
  cap_open_ends(mesh, repairs);
  orient_outward(mesh, repairs);
  EXPECT_TRUE(CGAL::is_closed(mesh));
  EXPECT_TRUE(shapes::reported(repairs, "open end capped"));
  expect_the_cones_ends(measure_ends(mesh));
}

TEST(Ends, FlatCapsAreFoundByShape) {
  Mesh mesh = cone(true);
  shapes::tag_ends(mesh);
  expect_the_cones_ends(measure_ends(mesh));
}

// The cone, open, with the half of its inlet's rim moved this far outwards.
Mesh stepped(double step) {
  Mesh mesh = cone(false);
  for (Vertex v : mesh.vertices())
    if (mesh.is_border(v) && mesh.point(v).x() < 1 && mesh.point(v).y() > 0)
      mesh.point(v) = Point(-step, mesh.point(v).y(), mesh.point(v).z());
  return mesh;
}

TEST(Ends, ARimSteppedByMoreThanItsRadiusIsRefusedWithItsPlace) {
  Mesh mesh = stepped(2.5);
  std::vector<Repair> repairs;
  EXPECT_THROW(cap_open_ends(mesh, repairs), common::InputError);
}

// The cone, open, with every other corner of its inlet's rim moved this far outwards.
Mesh toothed(double depth) {
  Mesh mesh = cone(false);
  bool tooth = false;
  for (const Loop& loop : boundary_loops(mesh))
    for (Vertex v : CGAL::vertices_around_face(loop.halfedge, mesh))
      if (mesh.point(v).x() < 1 && (tooth = !tooth))
        mesh.point(v) = Point(-depth, mesh.point(v).y(), mesh.point(v).z());
  return mesh;
}

TEST(Ends, AToothedRimIsCutBehindItsTeeth) {
  Mesh mesh = toothed(1);
  std::vector<Repair> repairs;
  const std::vector<OpenEnd> open = cap_open_ends(mesh, repairs);
  orient_outward(mesh, repairs);
  EXPECT_EQ(std::count_if(open.begin(), open.end(), [](const OpenEnd& end) { return end.ragged; }), 1);
  cut_ragged(mesh, open, repairs);
  EXPECT_TRUE(shapes::reported(repairs, "ragged end cut flat"));
  EXPECT_TRUE(CGAL::is_closed(mesh));
  const std::vector<End> ends = measure_ends(mesh);
  ASSERT_EQ(ends.size(), 2u);
  EXPECT_GT(ends[0].centre.x(), 0);
  EXPECT_LT(ends[0].centre.x(), 1);
  EXPECT_NEAR(ends[0].radius(), 1.6 - ends[0].centre.x() / 30, 0.05);
}

TEST(Ends, RemeshingKeepsTagsFlatnessAndQuality) {
  Mesh mesh = cone(true);
  shapes::tag_ends(mesh);
  measure_ends(mesh);
  for (double edge : {0.5, 0.25}) {
    Mesh fine = remeshed(mesh, edge, mesh);
    expect_the_cones_ends(measure_ends(fine));
    EXPECT_LT(flatten_caps(fine).distance, 1e-12);
    const Quality quality = quality_of(fine);
    EXPECT_GT(quality.min_angle_deg, 30) << edge;
    EXPECT_GT(quality.min_angle_rim_deg, 15) << edge;
    // chords of the new edges: (e / R)^2 / 6 of the area for the smaller end
    EXPECT_NEAR(quality.volume_mm3, quality_of(mesh).volume_mm3, edge * edge / 6 * quality.volume_mm3);
  }
}

TEST(Ends, TagsAreCarriedFromTheInput) {
  Soup soup = shapes::soup_of(shapes::straight(1.5, 10));
  for (const Triangle& t : soup.triangles) {
    const double x = soup.points[t[0]].x() + soup.points[t[1]].x() + soup.points[t[2]].x();
    soup.region.push_back(x < 1e-9 ? 7 : x > 30 - 1e-9 ? 4 : 0);
  }
  std::vector<Repair> repairs;
  Mesh mesh = repaired(soup, repairs);
  tag_from_soup(mesh, soup);
  EXPECT_EQ(measure_ends(mesh).size(), 2u);
}

std::vector<End> three_ends() {
  std::vector<End> ends(3);
  for (std::size_t e = 0; e < 3; ++e) {
    ends[e].centre = Vec3(10.0 * static_cast<double>(e), 0, 0);
    ends[e].area = 3 + static_cast<double>(e);
  }
  return ends;
}

// A prism of this many corners along x, with flat caps.
Mesh prism(int corners, double radius, double length, double spacing) {
  shapes::Tube tube = shapes::straight(radius, length);
  Soup soup;
  const int rings = static_cast<int>(std::lround(length / spacing));
  for (int i = 0; i <= rings; ++i)
    for (int k = 0; k < corners; ++k) {
      const double angle = 2 * pi * k / corners;
      soup.points.emplace_back(length * i / rings, radius * std::cos(angle), radius * std::sin(angle));
    }
  const auto id = [&](int i, int k) { return static_cast<std::size_t>(i * corners + k % corners); };
  for (int i = 0; i < rings; ++i)
    for (int k = 0; k < corners; ++k) {
      soup.triangles.push_back({id(i, k), id(i, k + 1), id(i + 1, k)});
      soup.triangles.push_back({id(i + 1, k), id(i, k + 1), id(i + 1, k + 1)});
    }
  for (int i : {0, rings})
    for (int k = 1; k + 1 < corners; ++k)
      soup.triangles.push_back({id(i, 0), id(i, k), id(i, k + 1)});
  std::vector<Repair> repairs;
  Mesh mesh = repaired(soup, repairs);
  orient_outward(mesh, repairs);
  region_map(mesh);
  return mesh;
}

TEST(FindEnds, FacetsOfALoftAreWall) {
  for (int corners : {4, 6, 8, 16})
    for (double spacing : {0.5, 3.0}) {
      Mesh mesh = prism(corners, 2, 20, spacing);
      shapes::tag_ends(mesh);
      const std::vector<End> ends = measure_ends(mesh);
      ASSERT_EQ(ends.size(), 2u) << corners << " corners, rings every " << spacing << " mm";
      for (const End& end : ends)
        EXPECT_NEAR(std::abs(end.normal.x()), 1, 1e-9);
    }
}

TEST(FindEnds, AVesselThatWidensBehindItsEndHasOne) {
  for (double slope : {0.3, -0.3}) { // of the radius: 17 degrees
    shapes::Tube tube = shapes::straight(1, 12);
    tube.radius = [=](double s) { return 1 + slope * std::min(s, 2.0); };
    tube.edge = 0.2;
    std::vector<Repair> repairs;
    Mesh mesh = repaired(shapes::soup_of(tube), repairs);
    region_map(mesh);
    shapes::tag_ends(mesh);
    EXPECT_EQ(measure_ends(mesh).size(), 2u) << slope;
  }
}

TEST(FindEnds, WhatThePointsNameDecides) {
  Mesh closed = cone(true);
  NamedEnds named;
  named.outlets = {Vec3(12, 0, 0)};
  shapes::tag_ends(closed, named); // the inlet is the larger one that is left
  expect_the_cones_ends(measure_ends(closed));
  named.outlets = {Vec3(12, 0, 0), Vec3(12.5, 0, 0)};
  Mesh twice = cone(true), away = cone(true);
  EXPECT_THROW(shapes::tag_ends(twice, named), common::InputError);
  named.outlets = {Vec3(12, 0, 0), Vec3(6, 9, 0)};
  EXPECT_THROW(shapes::tag_ends(away, named), common::InputError);
}

TEST(Naming, TheLargestEndIsTheInletUnlessGiven) {
  EXPECT_EQ(inlet_of(three_ends(), std::nullopt), 2u);
  EXPECT_EQ(inlet_of(three_ends(), Vec3(0.5, 0, 0)), 0u);
  EXPECT_THROW(inlet_of(three_ends(), Vec3(0, 50, 0)), common::InputError);
  EXPECT_THROW(inlet_of(std::vector<End>(1), std::nullopt), common::InputError);
}

TEST(Naming, OutletsByPoints) {
  const Naming naming = naming_from_points(three_ends(), Vec3(0, 0, 0), {Vec3(20, 0, 0), Vec3(10, 0.5, 0)});
  EXPECT_EQ(naming.inlet, 0u);
  EXPECT_EQ(naming.branch, (std::vector<int>{-1, 1, 0}));
  EXPECT_THROW(naming_from_points(three_ends(), Vec3(0, 0, 0), {Vec3(20, 0, 0)}), common::InputError);
  EXPECT_THROW(naming_from_points(three_ends(), Vec3(0, 0, 0), {Vec3(20, 0, 0), Vec3(20, 0, 0)}), common::InputError);
}

TEST(Naming, LikeAnEarlierState) {
  const auto like = nlohmann::json::parse(R"({"ends": [
    {"name": "inlet", "kind": "inlet", "branch": "main", "centre_mm": [10.2, 0, 0]},
    {"name": "outlet1", "kind": "outlet", "branch": "main", "centre_mm": [0, 0.3, 0]},
    {"name": "outlet3", "kind": "outlet", "branch": "side2", "centre_mm": [19, 0, 0]}]})");
  std::vector<End> ends = three_ends();
  const Naming naming = naming_from_earlier(ends, like);
  EXPECT_EQ(naming.inlet, 1u);
  EXPECT_EQ(naming.branch, (std::vector<int>{0, -1, 2}));
  std::vector<End> two = three_ends();
  two.pop_back();
  EXPECT_THROW(naming_from_earlier(two, like), common::InputError);
}

TEST(Ends, AScrapBesideACapIsWallAgain) {
  Mesh mesh = cone(true, 0.2);
  shapes::tag_ends(mesh);
  RegionMap region = region_map(mesh);
  const int tag = *std::max_element(region.begin(), region.end());
  const auto middle = [&](Face f) { return std::abs(mesh.point(mesh.target(mesh.halfedge(f))).x() - 6) < 0.5; };
  const Face scrap = *std::find_if(mesh.faces().begin(), mesh.faces().end(), middle);
  region[scrap] = tag;
  Mesh copy = mesh;
  ASSERT_EQ(measure_ends(copy).size(), 3u);
  std::vector<Repair> repairs;
  drop_scraps_of_caps(mesh, {}, repairs);
  EXPECT_TRUE(shapes::reported(repairs, "scrap of a cap taken as wall"));
  EXPECT_EQ(region[scrap], 0);
  expect_the_cones_ends(measure_ends(mesh));
}

TEST(Ends, ACapThatIsMovedByATenthOfItsRadiusIsWarnedOf) {
  for (const auto& [share, warned] : {std::pair{0.09, false}, {0.11, true}}) {
    std::vector<Repair> repairs;
    CapMove move;
    move.distance = 1.5 * share;
    move.share = share;
    report_cap_move(repairs, move, 2);
    ASSERT_EQ(repairs.size(), 1u);
    EXPECT_EQ(repairs[0].what, "caps flattened");
    EXPECT_EQ(repairs[0].warning, warned) << share;
  }
}

} // namespace
