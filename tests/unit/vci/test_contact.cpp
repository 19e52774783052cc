// Closest points, the broad phase and the one-sided contact law.
#include "vci/apposition.hpp"
#include "vci/closest_point.hpp"
#include "vci/contact.hpp"
#include "vci/device.hpp"
#include <algorithm>
#include <gtest/gtest.h>
#include <random>

namespace {

using namespace vci;

TEST(ClosestPoint, FindsFaceEdgesAndCorners) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  const auto foot = [&](const Vec3& p) {
    const ClosestPoint q = closest_on_triangle(p, a, b, c);
    return Vec3(q.weights[0] * a + q.weights[1] * b + q.weights[2] * c);
  };
  EXPECT_LT((foot({0.2, 0.3, 5}) - Vec3(0.2, 0.3, 0)).norm(), 1e-12);
  EXPECT_LT((foot({0.5, -1, 1}) - Vec3(0.5, 0, 0)).norm(), 1e-12);
  EXPECT_LT((foot({-1, 0.4, 1}) - Vec3(0, 0.4, 0)).norm(), 1e-12);
  EXPECT_LT((foot({1, 1, 1}) - Vec3(0.5, 0.5, 0)).norm(), 1e-12);
  EXPECT_LT((foot({-1, -1, 0}) - a).norm(), 1e-12);
  EXPECT_LT((foot({3, -1, 0}) - b).norm(), 1e-12);
  EXPECT_LT((foot({-1, 3, 0}) - c).norm(), 1e-12);
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
  // far, so that the boxes are fitted anew, and then a little, so that they are not
  for (const Vec3& shift : {Vec3(1, -1, 2), Vec3(0.05, -0.05, 0.05)}) {
    for (Vec3& p : x)
      p += shift + 0.001 * Vec3(number(random), number(random), number(random));
    boxes.update(triangles, x);
    for (int k = 0; k < 100; ++k) {
      const Vec3 p(number(random) + 1, number(random) - 1, number(random) + 2);
      constexpr double reach = 1.5, slack = 0.4;
      boxes.near(p, triangles, x, reach, slack, -1, found);
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

TEST(ContactRamp, IsSmoothOneSidedAndDerivesFromItsEnergy) {
  const ContactSettings s;
  EXPECT_EQ(contact_ramp(s.distance + 1e-9, s).pressure, 0);
  const double h = 1e-7;
  for (double gap : {0.005, -0.005, -0.05, -0.3}) {
    const RampLaw law = contact_ramp(gap, s);
    EXPECT_GT(law.pressure, 0);
    EXPECT_NEAR(law.pressure, -(contact_ramp(gap + h, s).energy - contact_ramp(gap - h, s).energy) / (2 * h), 1e-5);
    EXPECT_NEAR(law.stiffness, -(contact_ramp(gap + h, s).pressure - contact_ramp(gap - h, s).pressure) / (2 * h),
                1e-4);
  }
  EXPECT_LT(contact_ramp(s.distance - 0.9 * s.ramp, s).stiffness, s.stiffness);
  EXPECT_EQ(contact_ramp(s.distance - 1.1 * s.ramp, s).stiffness, s.stiffness);
}

TEST(AveragedRamp, IsTheMeanOverTheWay) {
  const ContactSettings s;
  constexpr double from = 0.02, to = -0.04; // free, on the ramp, beyond it
  double sum = 0;
  constexpr int parts = 20000;
  for (int k = 0; k < parts; ++k)
    sum += contact_ramp(from + (to - from) * (k + 0.5) / parts, s).pressure / parts;
  EXPECT_NEAR(averaged_ramp(from, to, s).pressure, sum, 1e-6);
  EXPECT_GT(averaged_ramp(from, to, s).stiffness, 0);
  EXPECT_NEAR(averaged_ramp(to, to, s).pressure, contact_ramp(to, s).pressure, 1e-12);
}

TEST(ContactRamp, ItsPartsFadeEachWithItsShareAndBelongTogether) {
  const ContactSettings s;
  for (const double share : {1.0, 0.4, 0.0}) // where ordinary contact gets to, the deep ramp's share is nothing to it
    for (const double deep : {1.0, 0.0})
      EXPECT_NEAR(contact_ramp(0, s, {share, deep}).pressure, share * contact_ramp(0, s).pressure, 1e-12);
  EXPECT_GT(contact_ramp(-0.06, s, {0.1, 1}).pressure, 0.7 * contact_ramp(-0.06, s).pressure);
  EXPECT_LT(contact_ramp(-0.06, s, {0.1, 0.1}).pressure, 0.11 * contact_ramp(-0.06, s).pressure);
  for (const double gap : {0.0, -0.03, -0.06}) { // force, stiffness and energy
    constexpr double h = 1e-6;
    const auto law = [&](double g) { return contact_ramp(g, s, {0.1, 0.6}); };
    const RampLaw here = law(gap), less = law(gap - h), more = law(gap + h);
    EXPECT_NEAR((less.energy - more.energy) / (2 * h), here.pressure, 1e-6 * here.pressure + 1e-9);
    EXPECT_NEAR((less.pressure - more.pressure) / (2 * h), here.stiffness, 1e-4 * here.stiffness);
  }
}

/// A tube of evenly spaced vertices about the z axis.
void add_tube(System& system, int around, double radius, double turn, const std::string& name = "tube") {
  RingGrid grid{around, {}, {}, {}};
  std::vector<Frame> frames;
  for (int r = 0; r < 12; ++r) {
    grid.s.push_back(0.7 * r);
    grid.profile.push_back(1);
    frames.push_back({Vec3(0, 0, grid.s[r]),
                      Vec3::UnitZ(),
                      {std::cos(turn), std::sin(turn), 0},
                      {-std::sin(turn), std::cos(turn), 0}});
  }
  const Vectors points = place_grid(grid, frames, std::vector<double>(grid.s.size(), radius));
  system.add_body(name, points, grid.triangles(), 1, std::vector<char>(points.size(), 0));
}

TEST(SurfaceContact, NestedTubesOfFewSidesMeetAsCirclesDo) {
  constexpr double inner = 1.5, between = 0.04;
  System system; // the inner tube's chords lie up to 0.073 mm within its circle, the outer one's 0.052 mm
  add_tube(system, 12, inner + between, 0);
  add_tube(system, 10, inner, 0.2);
  ContactSettings settings;
  settings.distance = 2 * between;
  const auto largest_error = [&] {
    SurfaceContact contact(1, 0, settings);
    std::vector<ContactPoint> found;
    contact.detect(system, area_vectors(system), found);
    double error = 0;
    int amid = 0; // away from the open ends, whose normals lean
    for (const ContactPoint& p : found)
      if (const double z = system.x[p.link.vertex[0]][2]; z > 1.5 && z < 6) {
        error = std::max(error, std::abs(p.gap - between));
        ++amid;
      }
    EXPECT_GT(amid, 60);
    return error;
  };
  EXPECT_LT(largest_error(), 0.004);
  settings.smooth = false;
  EXPECT_GT(largest_error(), 0.03) << "facets must show what is put right";
}

TEST(SurfaceContact, FindsOnTheWayWhatItWouldFindAnew) {
  ContactSettings settings; // far vertices are not searched for at every turn
  System system;            // a chord of the outer tube lies up to 0.073 mm within its circle
  add_tube(system, 10, 1.5, 0);
  add_tube(system, 12, 1.5, 0.2);
  const Body inner = system.body(1);
  const Vectors wide = system.x;
  const auto shrink = [&](double gap) {
    for (int v = inner.first; v < inner.first + inner.count; ++v)
      system.x[v].head<2>() = wide[v].head<2>() * (1 - gap / 1.5);
  };
  SurfaceContact on_the_way(1, 0, settings);
  std::size_t most = 0;
  for (double gap = 0.9; gap > -0.1; gap -= 0.007) {
    shrink(gap);
    std::vector<ContactPoint> found, anew;
    on_the_way.detect(system, area_vectors(system), found);
    SurfaceContact(1, 0, settings).detect(system, area_vectors(system), anew);
    ASSERT_EQ(found.size(), anew.size()) << "gap " << gap;
    for (std::size_t k = 0; k < found.size(); ++k)
      EXPECT_NEAR(found[k].gap, anew[k].gap, 1e-7); // mm: to which feet are followed
    most = std::max(most, found.size());
  }
  EXPECT_GT(most, 100u);
}

TEST(SurfaceContact, HoldsDeepVerticesNearlyToAWindowsRimButNotToAnEnd) {
  System system;
  add_tube(system, 12, 1.5, 0);
  add_tube(system, 16, 1.56, 0.1); // 0.06 mm through the first one, whose rings are the rows of 12 vertices
  for (int v = system.body(1).first; v < system.vertices(); ++v)
    system.x[v][2] += 0.3;
  std::vector<char> window(system.body(0).count, 0);
  window[6 * 12 + 3] = window[6 * 12 + 4] = window[7 * 12 + 4] = 1;
  SurfaceContact contact(1, 0, {}, {true, {}, window});
  std::vector<ContactPoint> found;
  const Vectors normals = area_vectors(system);
  contact.detect(system, normals, found);
  int at_window = 0, at_end = 0;
  for (const ContactPoint& p : found) {
    if (p.link.vertex[0] < system.body(1).first)
      continue;
    double end = 1, rim = 1;
    for (int k = 1; k < 4; ++k) {
      end -= system.body(0).boundary[p.link.vertex[k]] ? p.link.weight[k] : 0;
      rim -= window[p.link.vertex[k]] ? p.link.weight[k] : 0;
    }
    const double share = end < 1 ? end : rim, deep = end < 1 ? end : std::min(1.0, 10 * rim);
    const double area = normals[p.link.vertex[0]].norm();
    EXPECT_NEAR(p.area, share * area, 1e-12);
    EXPECT_NEAR(p.force, area * contact_ramp(p.gap, {}, {share, deep}).pressure, 1e-9);
    at_window += rim < 0.9;
    at_end += end < 0.9;
  }
  EXPECT_GE(at_window, 3);
  EXPECT_GE(at_end, 8);
}

TEST(Malapposition, IsTheGapBetweenTheCirclesNotTheirChords) {
  for (const double gap : {0.0, 0.05, 0.2}) {
    constexpr double radius = 1.5;
    System system; // chords of ten and twelve sides lie up to 0.08 and 0.05 mm within their circles
    add_tube(system, 12, radius + gap, 0);
    add_tube(system, 10, radius, 0.2, "stent");
    add_tube(system, 10, 0.5 * radius, 0.2, "balloon");
    add_tube(system, 10, radius - 0.3, 0.1, "stent"); // overlapped: the nearer one counts
    const std::vector<double> gaps = malapposition(system, "stent");
    int amid = 0; // away from the open ends, whose normals lean
    for (int v = 0; v < system.body(0).count; ++v)
      if (const double z = system.x[v][2]; z > 1.5 && z < 6) {
        EXPECT_NEAR(gaps[v], gap, 0.006);
        ++amid;
      }
    EXPECT_GT(amid, 60);
  }
}

TEST(Malapposition, IsNoneBeyondTheStentsEnds) {
  System system;
  add_tube(system, 12, 1.6, 0);
  add_tube(system, 10, 1.5, 0.2, "stent");
  for (int v = system.body(1).first; v < system.vertices(); ++v)
    system.x[v][2] = 2 + 0.4 * system.x[v][2]; // from 2 to 5.08 mm
  const std::vector<double> gaps = malapposition(system, "stent");
  for (int v = 0; v < system.body(0).count; ++v)
    if (const double z = system.x[v][2]; z < 1.5 || z > 5.5) {
      EXPECT_EQ(gaps[v], 0) << z;
    }
}

/// Contact of a small pyramid, body 1 with its tip at (0.1, 0, height) and its base at `base`, on a flat sheet (normal
/// +z).
std::vector<ContactPoint> pyramid_on_sheet(double base, double height, const Triangles& pyramid, ContactSides sides,
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

/// The pyramid inside, below the sheet, facing as the sheet does.
std::vector<ContactPoint> sheets(double height, Vectors& force) {
  return pyramid_on_sheet(-.4, height, {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}, {}, force);
}

TEST(SurfaceContact, PushesApartOnBothSidesOfTheSurfaceAndBalances) {
  Vectors force;
  EXPECT_TRUE(sheets(-0.05, force).empty());
  for (double height : {0.0, 0.1, 0.25}) { // through the wall, where an unsigned distance would let go
    const std::vector<ContactPoint> points = sheets(height, force);
    Vec3 sum = Vec3::Zero();
    for (const Vec3& f : force)
      sum += f;
    EXPECT_LT(sum.norm(), 1e-12);
    ASSERT_FALSE(points.empty());
    EXPECT_EQ(points[0].link.vertex[0], 9);
    EXPECT_NEAR(points[0].gap, -height, 1e-9);
    EXPECT_LT(force[9][2], 0);
  }
}

/// The pyramid above the sheet, facing it; tip and sheet are `gap` apart.
std::vector<ContactPoint> facing_sheets(double gap, ContactSides sides, Vectors& force) {
  return pyramid_on_sheet(.4, gap, {{0, 4, 1}, {1, 4, 2}, {2, 4, 3}, {3, 4, 0}}, std::move(sides), force);
}

TEST(SurfaceContact, SideBySideSurfacesPushOneAnotherAway) {
  Vectors force;
  const ContactSides beside{false, {}, {}};
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

TEST(SurfaceContact, BlindVerticesNeitherTouchNorAreTouched) {
  Vectors force;
  EXPECT_TRUE(facing_sheets(0, {false, {1, 1, 1, 1, 1}, {1, 1, 1, 1, 1}}, force).empty());
  for (const ContactPoint& p : facing_sheets(0, {false, {0, 0, 0, 0, 1}, {}}, force))
    EXPECT_NE(p.link.vertex[0], 9);
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
  EXPECT_NEAR(p.drag[0], -0.4 * limit, 1e-12);
  EXPECT_NEAR(p.link.tangential_stiffness, stiffness, 1e-12);
  slide(10);
  EXPECT_NEAR(p.drag[0], -limit, 1e-12);
  EXPECT_LT(p.link.tangential_stiffness, 0.1 * stiffness);
  const Mat3 sliding =
      p.link.stiffness(); // along its way the drag no longer grows, but for what keeps it from turning back
  EXPECT_NEAR(sliding(0, 0), 0.3 * sliding(1, 1), 1e-12);
  EXPECT_NEAR(sliding(2, 2), 6, 1e-12);
  slide(-limit / stiffness); // back by the elastic slip: the anchor has moved along
  EXPECT_NEAR(p.drag[0], 0, 1e-9);
  EXPECT_NEAR(p.link.stiffness()(0, 0), stiffness, 1e-12) << "it sticks again";
  Vectors f(2, Vec3::Zero());
  slide(-10);
  p.force = 0;
  add_contact_forces({p}, f);
  EXPECT_NEAR(f[1][0], limit, 1e-12); // opposes the motion
  EXPECT_LT((f[0] + f[1]).norm(), 1e-15);
}

TEST(Tie, StartsWithTheContactForceAndHoldsBothWays) {
  const ContactPoint point{
      {{0, 1, 2, 3}, {-1, 0.5, 0.25, 0.25}, Vec3::UnitZ(), 6, 0}, 0.1, 0.0, 0.3, Vec3::Zero(), nullptr};
  Vectors x{{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const Tie tie = tie_of(point, x, 60);
  Vectors f(4, Vec3::Zero());
  add_tie_forces({tie}, x, f);
  EXPECT_NEAR(f[0][2], -0.3, 1e-12);
  x[0] += Vec3(0.01, 0, -0.1); // pulled away and aside
  f.assign(4, Vec3::Zero());
  add_tie_forces({tie}, x, f);
  EXPECT_NEAR(f[0][2], -0.3 + 6 * 0.1, 1e-12);
  EXPECT_NEAR(f[0][0], -6 * 0.01, 1e-12);
}

} // namespace
