// Contact of nested tubes: fading towards open ends and windows, followed surface projections, malapposition.
#include "vci/contact/apposition.hpp"
#include "vci/contact/contact.hpp"
#include "vci/devices/balloon/balloon.hpp"
#include <algorithm>
#include <gtest/gtest.h>

namespace {

using namespace vci;

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
      if (const double z = system.x[p.stencil.vertex[0]][2]; z > 1.5 && z < 6) {
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
  ContactSettings settings; // vertices far from the surface are not searched at every call
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
      EXPECT_NEAR(found[k].gap, anew[k].gap, 1e-7); // mm, the tolerance of followed projections
    most = std::max(most, found.size());
  }
  EXPECT_GT(most, 100u);
}

/// A tube in an outer tube that has a window. The inner tube reaches `depth` (mm) through the outer one. Rings of the
/// outer tube have 12 vertices.
struct WindowedTubes {
  System system;
  std::vector<char> window, rim;
  Vectors normals;
  std::vector<ContactPoint> found;
  explicit WindowedTubes(double depth, bool with_rim = false) {
    add_tube(system, 12, 1.5, 0);
    add_tube(system, 16, 1.5 + depth, 0.1);
    for (int v = system.body(1).first; v < system.vertices(); ++v)
      system.x[v][2] += 0.3;
    window.assign(system.body(0).count, 0);
    window[6 * 12 + 3] = window[6 * 12 + 4] = window[7 * 12 + 4] = 1;
    rim.assign(window.size(), 0);
    for (const Triangle& t : system.body(0).triangles)
      for (int v : t)
        rim[v] |= with_rim && !window[v] && (window[t[0]] || window[t[1]] || window[t[2]]);
    normals = area_vectors(system);
    SurfaceContact(1, 0, {}, {true, {}, window, rim}).detect(system, normals, found);
  }
  /// The shares of the surface that remain where a point is projected: next to an end, and next to a window.
  std::array<double, 2> remaining_shares(const ContactPoint& p) const {
    std::array<double, 2> remaining_shares{1, 1};
    for (int k = 1; k < 4; ++k) {
      remaining_shares[0] -= system.body(0).boundary[p.stencil.vertex[k]] ? p.stencil.weight[k] : 0;
      remaining_shares[1] -= window[p.stencil.vertex[k]] || rim[p.stencil.vertex[k]] ? p.stencil.weight[k] : 0;
    }
    return remaining_shares;
  }
  bool of_inner_tube(const ContactPoint& p) const { return p.stencil.vertex[0] >= system.body(1).first; }
};

TEST(SurfaceContact, HoldsDeepVerticesNearlyToAWindowsRimButNotToAnEnd) {
  const WindowedTubes tubes(0.06);
  int at_window = 0, at_end = 0;
  for (const ContactPoint& p : tubes.found) {
    if (!tubes.of_inner_tube(p))
      continue;
    const auto [end, rim] = tubes.remaining_shares(p);
    const double share = end < 1 ? end : rim, deep = end < 1 ? end : std::min(1.0, 10 * rim);
    const double area = tubes.normals[p.stencil.vertex[0]].norm();
    EXPECT_NEAR(p.area, share * area, 1e-12);
    EXPECT_NEAR(p.force, area * penalty_response(p.gap, {}, {share, deep}).pressure, 1e-9);
    EXPECT_LT(p.gap, -0.04) << "what is deep beside a window is counted as deep";
    at_window += rim < 0.9;
    at_end += end < 0.9;
  }
  EXPECT_GE(at_window, 3);
  EXPECT_GE(at_end, 8);
}

TEST(SurfaceContact, EndsAtVerticesRoundAWindowThatTouchInTurn) {
  const WindowedTubes tubes(0.06, true);
  std::vector<int> touching(tubes.window.size(), 0);
  int before_rim = 0;
  for (const ContactPoint& p : tubes.found) {
    if (!tubes.of_inner_tube(p)) {
      ++touching[p.stencil.vertex[0]];
      continue;
    }
    const auto [end, rim] = tubes.remaining_shares(p);
    EXPECT_GT(rim, 0) << "nothing meets the rim or the window";
    EXPECT_NEAR(p.area, (end < 1 ? end : rim) * tubes.normals[p.stencil.vertex[0]].norm(), 1e-12);
    before_rim += rim < 0.9;
  }
  EXPECT_GE(before_rim, 6);
  for (std::size_t v = 0; v < touching.size(); ++v) {
    EXPECT_FALSE(tubes.window[v] && touching[v]) << v;
    EXPECT_TRUE(!tubes.rim[v] || touching[v]) << v << " holds the second tube off";
  }
  EXPECT_GE(std::count(tubes.rim.begin(), tubes.rim.end(), 1), 8);
}

TEST(Malapposition, IsTheGapBetweenTheCirclesNotTheirChords) {
  for (const double gap : {0.0, 0.05, 0.2, 2.5}) {
    constexpr double radius = 1.5;
    System system; // the stent's ten chords lie up to 0.07 mm within its circle
    add_tube(system, 12, radius + gap, 0);
    add_tube(system, 10, radius, 0.2, "stent");
    add_tube(system, 10, 0.5 * radius, 0.2, "balloon");
    add_tube(system, 10, radius - 0.3, 0.1, "stent"); // a second stent within the first; the nearer one counts
    const std::vector<double> gaps = malapposition(system, {{1}, {3}});
    int amid = 0; // away from the open ends, whose normals lean
    for (int v = 0; v < system.body(0).count; ++v)
      if (const double z = system.x[v][2]; z > 1.5 && z < 6) {
        EXPECT_NEAR(gaps[v], gap, 0.006 + 0.03 * gap); // far from the stent its coarse normals matter
        ++amid;
      }
    EXPECT_GT(amid, 60);
  }
}

TEST(Malapposition, IsNoneBeyondTheStentsEnds) {
  for (const double radius : {1.6, 4.0}) {
    System system;
    add_tube(system, 12, radius, 0);
    add_tube(system, 10, 1.5, 0.2, "stent");
    for (int v = system.body(1).first; v < system.vertices(); ++v)
      system.x[v][2] = 2 + 0.4 * system.x[v][2]; // from 2 to 5.08 mm
    const std::vector<double> gaps = malapposition(system, {{1}});
    for (int v = 0; v < system.body(0).count; ++v)
      if (const double z = system.x[v][2]; z < 1.5 || z > 5.5) {
        EXPECT_EQ(gaps[v], 0) << z << " " << radius;
      }
  }
}

TEST(Malapposition, CountsOnlyTheWallThatTheStentShouldLieAgainst) {
  System system;
  add_tube(system, 12, 2.0, 0);
  add_tube(system, 10, 1.5, 0.2, "stent");
  std::vector<char> flags(system.body(0).count, 1);
  for (int v = 0; v < system.body(0).count; ++v)
    flags[v] = system.x[v][0] > 0;
  const std::vector<double> gaps = malapposition(system, {{1, flags}});
  int counted = 0;
  for (int v = 0; v < system.body(0).count; ++v)
    if (const double z = system.x[v][2]; z > 1.5 && z < 6) {
      EXPECT_NEAR(gaps[v], flags[v] ? 0.5 : 0, 0.01);
      counted += flags[v];
    }
  EXPECT_GT(counted, 20);
}

} // namespace
