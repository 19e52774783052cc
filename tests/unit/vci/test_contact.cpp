// Closest points, the broad phase and the one-sided contact law.
#include "contact_checks.hpp"
#include "vci/contact/contact.hpp"
#include "vci/geometry/closest_point.hpp"
#include <algorithm>
#include <gtest/gtest.h>
#include <random>

namespace {

using namespace vci;

TEST(ClosestPoint, FindsFaceEdgesAndCorners) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  const auto projection = [&](const Vec3& p) {
    const ClosestPoint q = closest_on_triangle(p, a, b, c);
    return Vec3(q.weights[0] * a + q.weights[1] * b + q.weights[2] * c);
  };
  EXPECT_LT((projection({0.2, 0.3, 5}) - Vec3(0.2, 0.3, 0)).norm(), 1e-12);
  EXPECT_LT((projection({0.5, -1, 1}) - Vec3(0.5, 0, 0)).norm(), 1e-12);
  EXPECT_LT((projection({-1, 0.4, 1}) - Vec3(0, 0.4, 0)).norm(), 1e-12);
  EXPECT_LT((projection({1, 1, 1}) - Vec3(0.5, 0.5, 0)).norm(), 1e-12);
  EXPECT_LT((projection({-1, -1, 0}) - a).norm(), 1e-12);
  EXPECT_LT((projection({3, -1, 0}) - b).norm(), 1e-12);
  EXPECT_LT((projection({-1, 3, 0}) - c).norm(), 1e-12);
}

TEST(BroadPhase, FindsWhatASearchOverAllTrianglesFinds) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(0, 10);
  Vectors x;
  Triangles triangles;
  for (int k = 0; k < 200; ++k) {
    const Vec3 p(number(random), number(random), number(random));
    const int v = static_cast<int>(x.size());
    x.insert(x.end(), {p, p + Vec3(0.3, 0, 0), p + Vec3(0, 0.3, 0.1)});
    triangles.push_back({v, v + 1, v + 2});
  }
  BroadPhase boxes(triangles, x);
  std::vector<NearTriangle> found;
  std::size_t hits = 0, none = 0;
  // The first shift is so large that the boxes are fitted anew, the second so small that they are not.
  for (const Vec3& shift : {Vec3(1, -1, 2), Vec3(0.05, -0.05, 0.05)}) {
    for (Vec3& p : x)
      p += shift + 0.001 * Vec3(number(random), number(random), number(random));
    boxes.update(triangles, x);
    for (int k = 0; k < 100; ++k) {
      const Vec3 p(number(random) + 1, number(random) - 1, number(random) + 2);
      constexpr double reach = 1.5, slack = 0.4;
      boxes.find_near(p, triangles, x, reach, slack, -1, found);
      double nearest = 1e300;
      std::vector<double> distance;
      for (const Triangle& f : triangles) {
        distance.push_back(std::sqrt(closest_on_triangle(p, x[f[0]], x[f[1]], x[f[2]]).distance_squared));
        nearest = std::min(nearest, distance.back());
      }
      std::size_t expected = 0;
      for (double d : distance)
        expected += d <= reach && d <= nearest + slack;
      ASSERT_EQ(found.size(), expected);
      hits += found.size();
      none += found.empty();
      for (const NearTriangle& f : found)
        EXPECT_EQ(f.distance, distance[f.triangle]);
    }
  }
  EXPECT_GT(none, 5u) << "some points have nothing near";
  EXPECT_GT(hits, 20u) << "the search must find something to be a test";
}

TEST(SurfaceContact, AVertexBesideAFoldHasNoContact) {
  // A crumpled sheet with small triangles near it. The nearest point of a vertex beside a fold lies sideways, so its
  // gap along the normal is small. Such a vertex must have no contact: the gap must be half the distance or more.
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1, 1);
  System system;
  contact_checks::add_sheet(system, 9, 0.4, {0, 0, 0}, true);
  for (Vec3& p : system.x)
    p += Vec3(0.1 * number(random), 0.1 * number(random), 0.5 * number(random));
  Vectors points;
  Triangles triangles;
  for (int k = 0; k < 2000; ++k) {
    const Vec3 p(1.6 + 1.2 * number(random), 1.6 + 1.2 * number(random), number(random));
    const int v = static_cast<int>(points.size());
    for (int corner = 0; corner < 3; ++corner)
      points.push_back(p + 0.05 * Vec3(number(random), number(random), number(random)));
    triangles.push_back({v, v + 1, v + 2});
  }
  system.add_body("crumbs", points, triangles, 1, std::vector<char>(points.size(), 0));
  ContactSettings settings;
  settings.smooth = false;
  SurfaceContact contact(1, 0, settings);
  std::vector<ContactPoint> found;
  contact.detect(system, area_vectors(system), found);
  int far = 0;
  for (const ContactPoint& point : found) {
    Vec3 way = Vec3::Zero();
    for (int k = 0; k < 4; ++k)
      way += point.stencil.weight[k] * system.x[point.stencil.vertex[k]];
    far += way.norm() > 0.1;
    EXPECT_TRUE(way.norm() <= 0.1 || std::abs(point.gap) > 0.499 * way.norm()) << way.norm() << ", gap " << point.gap;
  }
  EXPECT_GT(far, 100) << "a vertex that is far through the sheet still has its contact";
}

TEST(ContactRamp, IsSmoothOneSidedAndDerivesFromItsEnergy) {
  const ContactSettings s;
  EXPECT_EQ(penalty_response(s.distance + 1e-9, s).pressure, 0);
  const double h = 1e-7;
  for (double gap : {0.005, -0.005, -0.05, -0.3}) {
    const PenaltyResponse law = penalty_response(gap, s);
    EXPECT_GT(law.pressure, 0);
    EXPECT_NEAR(law.pressure, -(penalty_response(gap + h, s).energy - penalty_response(gap - h, s).energy) / (2 * h),
                1e-5);
    EXPECT_NEAR(law.stiffness,
                -(penalty_response(gap + h, s).pressure - penalty_response(gap - h, s).pressure) / (2 * h), 1e-4);
  }
  EXPECT_LT(penalty_response(s.distance - 0.9 * s.ramp, s).stiffness, s.stiffness);
  EXPECT_EQ(penalty_response(s.distance - 1.1 * s.ramp, s).stiffness, s.stiffness);
  EXPECT_NEAR(penalty_response(s.distance - 3.6 * s.ramp, s).stiffness, 41 * s.stiffness, 1e-9) << "both ramps' lines";
}

TEST(AveragedRamp, IsTheMeanOverTheWay) {
  const ContactSettings s;
  constexpr double from = 0.02, to = -0.04; // the gap begins free, crosses the ramp and ends beyond it
  double sum = 0;
  constexpr int parts = 20000;
  for (int k = 0; k < parts; ++k)
    sum += penalty_response(from + (to - from) * (k + 0.5) / parts, s).pressure / parts;
  EXPECT_NEAR(averaged_response(from, to, s).pressure, sum, 1e-6);
  EXPECT_GT(averaged_response(from, to, s).stiffness, 0);
  EXPECT_NEAR(averaged_response(to, to, s).pressure, penalty_response(to, s).pressure, 1e-12);
}

TEST(ContactRamp, ItsPartsFadeEachWithItsShareAndBelongTogether) {
  const ContactSettings s;
  for (const double share : {1.0, 0.4, 0.0}) // at gap 0 the deep ramp adds nothing
    for (const double deep : {1.0, 0.0})
      EXPECT_NEAR(penalty_response(0, s, {share, deep}).pressure, share * penalty_response(0, s).pressure, 1e-12);
  EXPECT_GT(penalty_response(-0.06, s, {0.1, 1}).pressure, 0.7 * penalty_response(-0.06, s).pressure);
  EXPECT_LT(penalty_response(-0.06, s, {0.1, 0.1}).pressure, 0.11 * penalty_response(-0.06, s).pressure);
  // Pressure and stiffness are minus the derivatives of energy and pressure with respect to the gap.
  for (const double gap : {0.0, -0.03, -0.06}) {
    constexpr double h = 1e-6;
    const auto law = [&](double g) { return penalty_response(g, s, {0.1, 0.6}); };
    const PenaltyResponse here = law(gap), less = law(gap - h), more = law(gap + h);
    EXPECT_NEAR((less.energy - more.energy) / (2 * h), here.pressure, 1e-6 * here.pressure + 1e-9);
    EXPECT_NEAR((less.pressure - more.pressure) / (2 * h), here.stiffness, 1e-4 * here.stiffness);
  }
}

/// Contacts between a flat sheet (body 0, normal +z) and a small pyramid (body 1). The pyramid's tip is at
/// (0.1, 0, height), its base at z = base.
std::vector<ContactPoint> pyramid_on_sheet(double base, double height, const Triangles& pyramid, ContactScope sides,
                                           Vectors& force) {
  System system;
  const Vectors sheet{{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}, {0, 0, 0}};
  const Vectors points{{-.5, -.5, base}, {.5, -.5, base}, {.5, .5, base}, {-.5, .5, base}, {0.1, 0, height}};
  system.add_body("sheet", sheet, {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}, 1, std::vector<char>(5, 0));
  system.add_body("pyramid", points, pyramid, 1, std::vector<char>(5, 0));
  SurfaceContact contact(1, 0, {}, std::move(sides));
  std::vector<ContactPoint> found;
  contact.detect(system, area_vectors(system), found);
  force.assign(system.x.size(), Vec3::Zero());
  add_contact_forces(found, force);
  return found;
}

/// The base of the pyramid is below the sheet, as a device is inside a wall. Its sides face up, as the sheet does.
std::vector<ContactPoint> sheets(double height, Vectors& force) {
  return pyramid_on_sheet(-.4, height, {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}, {}, force);
}

TEST(SurfaceContact, PushesApartOnBothSidesOfTheSurfaceAndBalances) {
  Vectors force;
  EXPECT_TRUE(sheets(-0.05, force).empty());
  // The tip is on the sheet or through it. A contact by unsigned distance would not push a tip that is through.
  for (double height : {0.0, 0.1, 0.25}) {
    const std::vector<ContactPoint> points = sheets(height, force);
    Vec3 sum = Vec3::Zero();
    for (const Vec3& f : force)
      sum += f;
    EXPECT_LT(sum.norm(), 1e-12);
    ASSERT_FALSE(points.empty());
    EXPECT_EQ(points[0].stencil.vertex[0], 9);
    EXPECT_NEAR(points[0].gap, -height, 1e-9);
    EXPECT_LT(force[9][2], 0);
  }
}

/// The pyramid is above the sheet and faces it. Its tip is `gap` above the sheet.
std::vector<ContactPoint> facing_sheets(double gap, ContactScope sides, Vectors& force) {
  return pyramid_on_sheet(.4, gap, {{0, 4, 1}, {1, 4, 2}, {2, 4, 3}, {3, 4, 0}}, std::move(sides), force);
}

TEST(SurfaceContact, SideBySideSurfacesPushOneAnotherAway) {
  Vectors force;
  const ContactScope beside{false, {}, {}};
  EXPECT_TRUE(facing_sheets(0.05, beside, force).empty());
  for (double gap : {0.0, -0.1}) {
    const std::vector<ContactPoint> points = facing_sheets(gap, beside, force);
    ASSERT_FALSE(points.empty());
    EXPECT_NEAR(points[0].gap, gap, 1e-9);
    EXPECT_GT(force[9][2], 0);
    EXPECT_LT(force[4][2], 0);
  }
  EXPECT_TRUE(facing_sheets(-0.1, {}, force).empty()) << "nested tubes do not face each other";
}

TEST(SurfaceContact, ExcludedVerticesNeitherTouchNorAreTouched) {
  Vectors force;
  EXPECT_TRUE(facing_sheets(0, {false, {1, 1, 1, 1, 1}, {1, 1, 1, 1, 1}}, force).empty());
  for (const ContactPoint& p : facing_sheets(0, {false, {0, 0, 0, 0, 1}, {}}, force))
    EXPECT_NE(p.stencil.vertex[0], 9);
}

// The tip of the pyramid is 0.045 mm through the sheet. Its contact keeps the stiffening until the tip leaves the sheet
// along the normal.
TEST(SurfaceContact, StiffensOnlyWhatIsDeeperThanTheLimitUntilABound) {
  System system;
  const double depth = 0.045;
  const Vectors sheet{{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}, {0, 0, 0}};
  const Vectors points{{-.5, -.5, -.4}, {.5, -.5, -.4}, {.5, .5, -.4}, {-.5, .5, -.4}, {0.1, 0, depth}};
  system.add_body("sheet", sheet, {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}, 1, std::vector<char>(5, 0));
  system.add_body("pyramid", points, {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}, 1, std::vector<char>(5, 0));
  SurfaceContact contact(1, 0, {});
  const auto found = [&] {
    std::vector<ContactPoint> of;
    contact.detect(system, area_vectors(system), of);
    return of;
  };
  const auto tip_force = [&] { return found().at(0).force; };
  const double at_first = tip_force();
  EXPECT_FALSE(stiffen_deep_contacts(found(), depth + 0.001));
  EXPECT_EQ(tip_force(), at_first);
  EXPECT_TRUE(stiffen_deep_contacts(found(), depth - 0.001));
  const ContactSettings s;
  const double ordinary = penalty_response(-depth, s, {1, 0}).pressure, both = penalty_response(-depth, s).pressure;
  EXPECT_NEAR(tip_force() / at_first, (2 * both - ordinary) / both, 1e-9);
  int times = 1;
  while (stiffen_deep_contacts(found(), depth - 0.001))
    ASSERT_LT(++times, 100);
  EXPECT_EQ(times, 6);
  const double stiffened = tip_force();
  system.x[9][0] = 2.05; // beyond the sheet's edge and back at the same depth: the contact stays stiffened
  for (const ContactPoint& p : found())
    EXPECT_NE(p.stencil.vertex[0], 9);
  system.x[9][0] = 0.1;
  EXPECT_EQ(tip_force(), stiffened);
  system.x[9][2] = -0.2; // away from the sheet and back: the contact has its first stiffness again
  EXPECT_TRUE(found().empty());
  system.x[9][2] = depth;
  EXPECT_EQ(tip_force(), at_first);
}

TEST(Friction, SticksElasticallyThenSlidesAtTheLimitAndRemembersTheAnchor) {
  const ContactSettings s;
  Vec3 slip = Vec3::Zero();
  ContactPoint p{{{0, 1, 1, 1}, {-1, 1, 0, 0}, Vec3::UnitZ(), 6, 0}, 0.2, 0.0, 0.5, Vec3::Zero(), &slip};
  const double stiffness = s.friction_stiffness * p.area, limit = s.friction * p.force;
  const auto slide = [&](double distance) {
    add_slip({p}, {Vec3::Zero(), Vec3(distance, 0, 0)});
    add_friction(p, s);
  };
  slide(0.4 * limit / stiffness);
  EXPECT_NEAR(p.friction[0], -0.4 * limit, 1e-12);
  EXPECT_NEAR(p.stencil.tangential_stiffness, stiffness, 1e-12);
  slide(10);
  EXPECT_NEAR(p.friction[0], -limit, 1e-12);
  EXPECT_LT(p.stencil.tangential_stiffness, 0.1 * stiffness);
  // Along the slip the friction force no longer grows. A part of the stiffness stays, to resist a turn back.
  const Mat3 sliding = p.stencil.stiffness();
  EXPECT_NEAR(sliding(0, 0), 0.3 * sliding(1, 1), 1e-12);
  EXPECT_NEAR(sliding(2, 2), 6, 1e-12);
  slide(-limit / stiffness); // back by the elastic slip, to the anchor, which has followed the slide
  EXPECT_NEAR(p.friction[0], 0, 1e-9);
  EXPECT_NEAR(p.stencil.stiffness()(0, 0), stiffness, 1e-12) << "it sticks again";
  Vectors f(2, Vec3::Zero());
  slide(-10);
  p.force = 0;
  add_contact_forces({p}, f);
  EXPECT_NEAR(f[1][0], limit, 1e-12); // friction opposes the motion
  EXPECT_LT((f[0] + f[1]).norm(), 1e-15);
}

TEST(Tie, StartsWithTheContactForceAndHoldsBothWays) {
  const ContactPoint point{
      {{0, 1, 2, 3}, {-1, 0.5, 0.25, 0.25}, Vec3::UnitZ(), 6, 0}, 0.1, 0.0, 0.3, Vec3::Zero(), nullptr};
  Vectors x{{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const Tie tie = make_tie(point, x, 60);
  Vectors f(4, Vec3::Zero());
  add_tie_forces({tie}, x, f);
  EXPECT_NEAR(f[0][2], -0.3, 1e-12);
  x[0] += Vec3(0.01, 0, -0.1); // vertex 0 is pulled away and aside
  f.assign(4, Vec3::Zero());
  add_tie_forces({tie}, x, f);
  EXPECT_NEAR(f[0][2], -0.3 + 6 * 0.1, 1e-12);
  EXPECT_NEAR(f[0][0], -6 * 0.01, 1e-12);
}

} // namespace
