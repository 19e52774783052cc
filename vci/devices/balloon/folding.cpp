#include "vci/devices/balloon/folding.hpp"
#include "common/error.hpp"
#include "vci/devices/balloon/balloon_chart.hpp"

#include <algorithm>
#include <cmath>

namespace vci {

namespace {

constexpr double edge_over_thickness = 6; // longest edge that can follow the folds, over the film's thickness
constexpr double nylon_modulus = 900, nylon_poisson = 0.4; // MPa, and Poisson's ratio; oriented polyamide 12
// Number of ever finer grids tried. A valley between wings has a whole number of edges, which widens it on a coarse
// grid. A finer grid may fit the crimped profile.
constexpr int finer_grids = 8;

Vec2 at_angle(double radius, double angle) {
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

/// The section of a layer of film that lies `depth` inside the spiral r = start + climb * phi.
struct Arm {
  double start, climb, depth; ///< mm, mm/rad, mm
  double radius(double phi) const { return start + climb * phi - depth; }
  Vec2 at(double phi) const { return at_angle(radius(phi), phi); }
  /// The angle beyond `from` (rad) at which the arm is a distance `edge` (mm) from p, by Newton's method.
  double next(const Vec2& p, double from, double edge) const {
    double phi = from + edge / radius(from);
    for (int iteration = 0; iteration < 10; ++iteration) {
      const Vec2 d = at(phi) - p, along = climb * at_angle(1, phi) + at_angle(radius(phi), phi + 0.5 * pi);
      phi -= (d.squaredNorm() - edge * edge) / (2 * d.dot(along));
    }
    return phi;
  }
};

/// Section of one wing: the two paths of film from the valleys beside the wing to its crest.
struct Sector {
  std::vector<Vec2> back, belly; ///< points after the valley's end, up to the crest where both paths meet, mm
  Vec2 root;                     ///< the valley's end at which the back begins, mm
  double opening;                ///< angle from the belly's end to the back's end, rad; 0 if the ring is closed
  double wrap;                   ///< angle that the belly covers, rad
};

/// The wing whose back and belly have these numbers of edges.
/// @param edge length of the edges, mm
/// @param inner radius (mm) at which the valley between two wings begins
Sector sector_of(const FoldingSpec& f, int back, int belly, double edge, double inner) {
  const double t = f.membrane_thickness, between = 2 * pi / f.wings, climb = t * f.wings / pi;
  const Arm top{inner + 2 * t, climb, 0}, bottom{inner + 2 * t, climb, t}, middle{inner + 2 * t, climb, 0.5 * t};
  const auto walk = [&](const Arm& arm, Vec2 p, double phi, int edges, std::vector<Vec2>& points) {
    for (int k = 0; k < edges; ++k) {
      const Arm& on = k + 1 < edges ? arm : middle;
      phi = on.next(p, phi, edge);
      p = on.at(phi);
      points.push_back(p);
    }
    return phi;
  };
  Sector s;
  const double root = inner + 0.5 * t;
  s.root = at_angle(root, -between);
  const double crest_of_back = walk(top, s.root, -between, back, s.back);
  const double crest_of_belly = walk(bottom, at_angle(root, 0), 0, belly, s.belly);
  s.opening = crest_of_back - crest_of_belly;
  s.wrap = crest_of_belly;
  return s;
}

/// The radius (mm) at which valleys must begin so that back and belly meet and the ring is closed, by bisection.
double closing_radius(const FoldingSpec& f, int back, int belly, double edge) {
  const double guess = (back - belly) * edge * f.wings / (2 * pi);
  double low = std::max(0.2 * guess, 1e-3), high = 1.5 * guess + edge;
  for (int iteration = 0; iteration < 60; ++iteration) {
    const double middle = 0.5 * (low + high);
    (sector_of(f, back, belly, edge, middle).opening > 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double least_radius(const FoldingSpec& f) {
  return 0.5 * f.shaft_diameter + 0.5 * f.membrane_thickness;
}

/// Mirrors the points, for wings that are wrapped clockwise, and keeps their order counterclockwise.
void turn_clockwise(std::vector<Vec2>& points) {
  for (Vec2& p : points)
    p[1] = -p[1];
  std::reverse(points.begin() + 1, points.end());
}

/// Number of edges of a valley: the fewest that keep the valley outside the shaft. 0 if too few edges are left for
/// wings.
int valley_edges(const FoldingSpec& f, int per_wing, double edge) {
  for (int valley = 2; valley + 4 <= per_wing; valley += 2)
    if (closing_radius(f, (per_wing + valley) / 2, (per_wing - valley) / 2, edge) >= least_radius(f))
      return valley;
  return 0;
}

} // namespace

FoldedSection folded_section(const FoldingSpec& f, int around, double edge) {
  const int per_wing = around / f.wings, valley = valley_edges(f, per_wing, edge);
  FoldedSection section{{}, 1e300, 0, 0};
  if (valley == 0)
    return section;
  const int back = (per_wing + valley) / 2, belly = (per_wing - valley) / 2;
  const Sector s = sector_of(f, back, belly, edge, closing_radius(f, back, belly, edge));
  section.points.resize(around);
  section.wrap = s.wrap;
  for (int wing = 0; wing < f.wings; ++wing) {
    const Eigen::Rotation2Dd turn(2 * pi * wing / f.wings);
    const auto put = [&](int k, const Vec2& p) {
      section.points[(wing * per_wing + k + around) % around] = turn * p;
      section.inner = std::min(section.inner, p.norm());
      section.outer = std::max(section.outer, p.norm());
    };
    put(-valley / 2, s.root);
    for (int k = 0; k < back; ++k)
      put(k + 1 - valley / 2, s.back[k]);
    for (int k = 0; k + 1 < belly; ++k)
      put(per_wing - valley / 2 - 1 - k, s.belly[k]);
  }
  if (f.clockwise)
    turn_clockwise(section.points);
  return section;
}

double unfolded_diameter(const BalloonSpec& spec) {
  return BalloonChart::of_unfolded(spec.chart_pressure_bar, spec.chart_diameter).diameter_at(0);
}

double bending_rigidity(const FoldingSpec& f) {
  return nylon_modulus * std::pow(f.membrane_thickness, 3) / (12 * (1 - nylon_poisson * nylon_poisson));
}

namespace {

/// Length (mm) of the edges round the unfolded balloon's body, with `around` edges.
double unfolded_edge(const BalloonSpec& spec, int around) {
  return unfolded_diameter(spec) * std::sin(pi / around);
}

} // namespace

int vertices_round_folded(const BalloonSpec& spec, double edge) {
  const FoldingSpec& f = *spec.folding;
  const double perimeter = pi * unfolded_diameter(spec);
  const double fine = std::min(edge, edge_over_thickness * f.membrane_thickness);
  const int least = 2 * std::max(4, static_cast<int>(std::ceil(0.5 * perimeter / f.wings / fine)));
  double narrowest = 1e300;
  for (int more = 0; more < finer_grids; ++more) {
    const int around = f.wings * (least + 2 * more);
    const FoldedSection section = folded_section(f, around, unfolded_edge(spec, around));
    if (section.points.empty())
      throw common::InputError("a balloon too small to be folded", "folding",
                               "perimeter " + std::to_string(perimeter) + " mm round a shaft of " +
                                   std::to_string(f.shaft_diameter) + " mm in " + std::to_string(f.wings) + " wings",
                               "fold it into fewer wings, lower shaft_diameter_mm, or leave folding off");
    if (2 * section.outer <= spec.crimped_diameter)
      return around;
    narrowest = std::min(narrowest, 2 * section.outer);
  }
  throw common::InputError("the folded balloon does not fit into its profile", "folding",
                           "perimeter " + std::to_string(perimeter) + " mm in " + std::to_string(f.wings) +
                               " wings needs " + std::to_string(narrowest) + " mm, crimped_diameter_mm is " +
                               std::to_string(spec.crimped_diameter),
                           "raise crimped_diameter_mm, or lower membrane_thickness_mm or shaft_diameter_mm");
}

FoldedSection folded_section(const BalloonSpec& spec, int around) {
  return folded_section(*spec.folding, around, unfolded_edge(spec, around));
}

Vectors place_folded(const BalloonSpec& spec, const RingGrid& grid, const std::vector<Frame>& frames,
                     const std::vector<double>& room) {
  const FoldedSection section = folded_section(spec, grid.around);
  Vectors points;
  for (int r = 0; r < grid.rings(); ++r) {
    const double needs = grid.profile[r] * section.outer;
    if (needs > room[r] + 1e-9)
      throw common::ComputationError("a folded balloon does not fit where it is placed",
                                     "ring at " + std::to_string(grid.s[r]) + " mm from its centre",
                                     std::to_string(2 * needs) + " mm wide, room for " + std::to_string(2 * room[r]) +
                                         " mm",
                                     "dilate first with a smaller balloon, fold it tighter (wings, "
                                     "membrane_thickness_mm), or leave folding off for it");
    for (const Vec2& p : section.points)
      points.push_back(frames[r].origin + grid.profile[r] * (p[0] * frames[r].first + p[1] * frames[r].second));
  }
  return points;
}

} // namespace vci
