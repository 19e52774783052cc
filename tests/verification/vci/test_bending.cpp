// Balloons and stents bend as beams. The moment that holds their ends at an angle is compared with closed forms.
#include "vci/devices/balloon/balloon.hpp"
#include "vci/devices/stent/stent.hpp"
#include "vci/solver/integrator.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>

namespace {

using namespace vci;

constexpr double half_length = 4.0;     // mm: rings further from the middle are held fixed
constexpr double edge = 0.45;           // mm
constexpr double axial_stiffness = 8.0; // N/mm, of a balloon at its nominal diameter
constexpr double tip = 0.35;            // diameter of a balloon's open end over the balloon's diameter

/// An arc of curvature k (1/mm) up to the arc length `half` on both sides of the origin, straight beyond.
std::vector<Frame> arc(const RingGrid& grid, double k, double half) {
  std::vector<Frame> frames;
  for (double s : grid.s) {
    const double on_arc = std::clamp(s, -half, half), a = k * on_arc;
    const Vec3 tangent(-std::sin(a), 0, std::cos(a)), outward(std::cos(a), 0, std::sin(a));
    const Vec3 origin((std::cos(a) - 1) / k, 0, std::sin(a) / k);
    frames.push_back({origin + (s - on_arc) * tangent, tangent, outward, tangent.cross(outward)});
  }
  return frames;
}

/// The first ring that is held fixed at the upper end.
int first_held(const RingGrid& grid) {
  int ring = grid.rings();
  while (grid.s[ring - 1] > half_length)
    --ring;
  return ring;
}

/// Moment (N mm) on the upper end about the centre of its first ring.
double moment_on(System& system, const RingGrid& grid, const Frame& held) {
  Vectors elastic, foundation, pressure;
  system.evaluate(elastic, foundation, pressure, false);
  Vec3 moment = Vec3::Zero();
  for (int i = first_held(grid) * grid.ring_size; i < system.vertices(); ++i)
    moment += (system.x[i] - held.origin).cross(elastic[i] + pressure[i]);
  return std::abs(moment.y());
}

void balance(System& system, const RingGrid& grid, double tolerance) {
  for (int i = 0; i < system.vertices(); ++i)
    system.fixed[i] = std::abs(grid.s[i / grid.ring_size]) > half_length;
  Interactions none;
  IntegratorSettings settings;
  settings.residual_tolerance = tolerance;
  EXPECT_TRUE(relax(system, none, settings).converged);
}

struct BentBalloon {
  double moment, length; ///< N mm; mm between the held rings
  double radius;         ///< mm, from the balloon's chart
  int ring_size;
};

/// A 3 mm balloon under pressure (MPa) whose ends are held on an arc of curvature k (1/mm).
BentBalloon bent_balloon(double pressure, double k) {
  const BalloonSpec spec{3.0, 12.0, 1.5, 0.8, 14.0, {2, 6, 10, 14, 18}, {2.76, 2.93, 3.06, 3.19, 3.31}};
  const BalloonChart chart({0.2, 0.6, 1.0, 1.4, 1.8}, spec.chart_diameter, spec.crimped_diameter);
  const RingGrid grid = balloon_grid(spec, edge);
  const int ring = first_held(grid);
  const std::vector<Frame> frames = arc(grid, k, grid.s[ring]);
  const double radius = 0.5 * chart.diameter_at(pressure);
  std::vector<double> radii;
  for (double profile : grid.profile)
    radii.push_back(radius * profile);
  System system;
  Balloon balloon = add_balloon(system, spec, grid, frames, radii);
  set_pressure(balloon, pressure);
  balance(system, grid, 1e-5);
  return {moment_on(system, grid, frames[ring]), 2 * grid.s[ring], radius, grid.ring_size};
}

/// Stiffness of all axial fibres together (N). It is fixed by the nominal diameter of 3 mm.
constexpr double all_fibres = 2 * pi * 1.5 * axial_stiffness;

TEST(Bending, TautBalloonIsAnEulerBernoulliBeam) {
  for (double pressure : {0.2, 0.6, 1.0}) {
    const double k = pressure < 0.5 ? 0.006 : 0.01; // so small that no fibre goes slack
    const BentBalloon b = bent_balloon(pressure, k);
    const double stiffness = 0.5 * all_fibres * b.radius * b.radius; // pi R^3 times stiffness per circumference
    // The pressure on the polygon of a ring pushes axially. The fibres pull less, because the open tips carry no
    // pressure. The balloon is therefore a beam column under the difference, between clamps that are turned.
    const double circle = pi * b.radius * b.radius, polygon = 0.5 * b.ring_size * std::sin(2 * pi / b.ring_size) / pi;
    const double push = pressure * circle * (polygon - (1 - tip * tip));
    const double half = 0.5 * b.length * std::sqrt(push / stiffness);
    EXPECT_NEAR(b.moment / (k * stiffness * half / std::tan(half)), 1, 0.02) << pressure << " MPa";
  }
}

TEST(Bending, BalloonWrinklesWhereItsInnerFibresGoSlack) {
  const double pressure = 0.2;
  for (double k : {0.02, 0.04}) {
    const BentBalloon b = bent_balloon(pressure, k);
    const double pull = pressure * pi * b.radius * b.radius * (1 - tip * tip);
    double moment = 0;
    for (int i = 0; i < b.ring_size; ++i) {
      const double lever = b.radius * std::cos(2 * pi * i / b.ring_size), strain = std::log1p(k * lever);
      const double slack = std::min(0.0, strain + pull / all_fibres); // a slack fibre keeps 2 % of its stiffness
      moment += (all_fibres * (strain - 0.98 * slack) / (1 + k * lever) + pull) * lever / b.ring_size;
    }
    EXPECT_NEAR(b.moment / moment, 1, 0.02) << k << " /mm";
    EXPECT_LT(b.moment, 0.85 * k * 0.5 * all_fibres * b.radius * b.radius) << "it wrinkles";
  }
}

/// Bending stiffness (N mm^2) of a stent of this nominal diameter (mm): {its ends held on an arc, balanced between
/// them}.
std::array<double, 2> stent_stiffness(double diameter, double stated) {
  const StentSpec spec{diameter, 12, 1.0, 4.4, 0.08, 8, 2, "b", 11, 0.5, stated, 0.22, 4.5};
  const RingGrid grid = stent_grid(spec, edge);
  const double k = 0.01;
  const std::vector<Frame> frames = arc(grid, k, spec.length);
  const std::vector<double> radii(grid.rings(), 0.5 * diameter);
  System system;
  const Stent stent = add_stent(system, spec, "stent", grid, arc(grid, 1e-9, spec.length), radii);
  system.x = place_grid(grid, frames, radii);
  const Frame& held = frames[first_held(grid)];
  const double on_arc = moment_on(system, grid, held) / k;
  // The residual is relative to the applied forces. A small pressure gives it a scale.
  system.add_force(stent.body, std::make_unique<Pressure>(system.body(stent.body).triangles, system.x, 1e-3));
  balance(system, grid, 1e-2);
  return {on_arc, moment_on(system, grid, held) / k};
}

TEST(Bending, StentHasItsStatedStiffness) {
  for (double diameter : {2.25, 3.0, 3.5})
    for (double stated : {20.0, 40.0})
      for (double found : stent_stiffness(diameter, stated))
        EXPECT_NEAR(found / stated, 1, 0.06) << diameter << " mm, stated " << stated;
}

TEST(Bending, WideStentHasTheStiffnessOfItsLeastFibresFilmAndHinges) {
  for (double diameter : {4.0, 4.5}) {
    const double radius = 0.5 * diameter, buckling = 0.22 * radius * radius * radius / 3, film = 0.3, fibres = 0.5;
    const double of_hinges = 0.5 * pi * diameter * buckling; // half of n hinges of length pi D / n
    const double expected = pi * radius * radius * radius * (film + fibres) + of_hinges;
    for (double found : stent_stiffness(diameter, 20))
      EXPECT_NEAR(found / expected, 1, 0.06) << diameter << " mm, " << found << " N mm2";
  }
}

} // namespace
