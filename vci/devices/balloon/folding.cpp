#include "vci/devices/balloon/folding.hpp"
#include "common/error.hpp"
#include "vci/devices/balloon/balloon_chart.hpp"

#include <algorithm>
#include <cmath>

namespace vci {

namespace {

constexpr double edge_over_thickness = 6; // longest edge that can follow the folds, over the film's thickness
constexpr double nylon_modulus = 900, nylon_poisson = 0.4; // MPa, and Poisson's ratio; oriented polyamide 12
// Number of grids tried, each finer than the one before. A valley between wings has a whole number of edges, so on a
// coarse grid it is too wide. A finer grid may fit into the crimped profile.
constexpr int grid_attempts = 8;

Vec2 polar_point(double radius, double angle) {
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

/// A layer of film in the cross-section. It lies `depth` inside the spiral r = start + climb * phi.
struct Arm {
  double start, climb, depth; ///< mm, mm/rad, mm
  double radius(double phi) const { return start + climb * phi - depth; }
  Vec2 at(double phi) const { return polar_point(radius(phi), phi); }
  /// The angle beyond `from` (rad) at which the arm is a distance `edge` (mm) from p, by Newton's method.
  double next(const Vec2& p, double from, double edge) const {
    double phi = from + edge / radius(from);
    for (int iteration = 0; iteration < 10; ++iteration) {
      const Vec2 d = at(phi) - p, along = climb * polar_point(1, phi) + polar_point(radius(phi), phi + 0.5 * pi);
      phi -= (d.squaredNorm() - edge * edge) / (2 * d.dot(along));
    }
    return phi;
  }
};

/// Section of one wing: the two paths of film from the valleys beside the wing to its crest.
struct WingSection {
  std::vector<Vec2> back, belly; ///< points after the valley's end, up to the crest where both paths meet, mm
  Vec2 root;                     ///< the valley's end at which the back begins, mm
  double opening;                ///< angle from the belly's end to the back's end, rad; 0 if the ring is closed
};

/// The wing whose back and belly have these numbers of edges.
/// @param edge length of the edges, mm
/// @param inner radius (mm) at which the valley between two wings begins
WingSection wing_section(const FoldingSpec& f, int back, int belly, double edge, double inner) {
  const double t = f.membrane_thickness, sector_angle = 2 * pi / f.wings, climb = t * f.wings / pi;
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
  WingSection s;
  const double root = inner + 0.5 * t;
  s.root = polar_point(root, -sector_angle);
  const double crest_of_back = walk(top, s.root, -sector_angle, back, s.back);
  const double crest_of_belly = walk(bottom, polar_point(root, 0), 0, belly, s.belly);
  s.opening = crest_of_back - crest_of_belly;
  return s;
}

/// The radius (mm) at which valleys must begin so that back and belly meet and the ring is closed, by bisection.
double closing_radius(const FoldingSpec& f, int back, int belly, double edge) {
  const double guess = (back - belly) * edge * f.wings / (2 * pi);
  double low = std::max(0.2 * guess, 1e-3), high = 1.5 * guess + edge;
  for (int iteration = 0; iteration < 60; ++iteration) {
    const double middle = 0.5 * (low + high);
    (wing_section(f, back, belly, edge, middle).opening > 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double least_valley_radius(const FoldingSpec& f) {
  return 0.5 * f.shaft_diameter + 0.5 * f.membrane_thickness;
}

/// Mirrors the points, for wings that are wrapped clockwise, and keeps their order counterclockwise.
void mirror_points(std::vector<Vec2>& points) {
  for (Vec2& p : points)
    p[1] = -p[1];
  std::reverse(points.begin() + 1, points.end());
}

/// Number of edges of a valley: the fewest that keep the valley outside the shaft. 0 if too few edges are left for
/// wings.
int valley_edges(const FoldingSpec& f, int per_wing, double edge) {
  for (int valley = 2; valley + 4 <= per_wing; valley += 2)
    if (closing_radius(f, (per_wing + valley) / 2, (per_wing - valley) / 2, edge) >= least_valley_radius(f))
      return valley;
  return 0;
}

} // namespace

FoldedSection folded_section(const FoldingSpec& f, int ring_size, double edge) {
  const int per_wing = ring_size / f.wings, valley = valley_edges(f, per_wing, edge);
  FoldedSection section{{}, 1e300, 0};
  if (valley == 0)
    return section;
  const int back = (per_wing + valley) / 2, belly = (per_wing - valley) / 2;
  const WingSection s = wing_section(f, back, belly, edge, closing_radius(f, back, belly, edge));
  section.points.resize(ring_size);
  for (int wing = 0; wing < f.wings; ++wing) {
    const Eigen::Rotation2Dd turn(2 * pi * wing / f.wings);
    const auto put = [&](int k, const Vec2& p) {
      section.points[(wing * per_wing + k + ring_size) % ring_size] = turn * p;
      section.inner_radius = std::min(section.inner_radius, p.norm());
      section.outer_radius = std::max(section.outer_radius, p.norm());
    };
    put(-valley / 2, s.root);
    for (int k = 0; k < back; ++k)
      put(k + 1 - valley / 2, s.back[k]);
    for (int k = 0; k + 1 < belly; ++k)
      put(per_wing - valley / 2 - 1 - k, s.belly[k]);
  }
  if (f.clockwise)
    mirror_points(section.points);
  return section;
}

double unfolded_diameter(const BalloonSpec& spec) {
  return BalloonChart::of_unfolded(spec.chart_pressure_bar, spec.chart_diameter).diameter_at(0);
}

double bending_rigidity(const FoldingSpec& f) {
  return nylon_modulus * std::pow(f.membrane_thickness, 3) / (12 * (1 - nylon_poisson * nylon_poisson));
}

namespace {

/// Length (mm) of the edges round the unfolded balloon's body, with `ring_size` edges.
double unfolded_edge(const BalloonSpec& spec, int ring_size) {
  return unfolded_diameter(spec) * std::sin(pi / ring_size);
}

} // namespace

int folded_ring_size(const BalloonSpec& spec, double edge) {
  const FoldingSpec& f = *spec.folding;
  const double perimeter = pi * unfolded_diameter(spec);
  const double fine = std::min(edge, edge_over_thickness * f.membrane_thickness);
  const int least = 2 * std::max(4, static_cast<int>(std::ceil(0.5 * perimeter / f.wings / fine)));
  double least_diameter = 1e300;
  for (int attempt = 0; attempt < grid_attempts; ++attempt) {
    const int ring_size = f.wings * (least + 2 * attempt);
    const FoldedSection section = folded_section(f, ring_size, unfolded_edge(spec, ring_size));
    if (section.points.empty())
      throw common::InputError("a balloon too small to be folded", "folding",
                               "perimeter " + std::to_string(perimeter) + " mm round a shaft of " +
                                   std::to_string(f.shaft_diameter) + " mm in " + std::to_string(f.wings) + " wings",
                               "fold it into fewer wings, lower shaft_diameter_mm, or leave folding off");
    if (2 * section.outer_radius <= spec.crimped_diameter)
      return ring_size;
    least_diameter = std::min(least_diameter, 2 * section.outer_radius);
  }
  throw common::InputError("the folded balloon does not fit into its profile", "folding",
                           "perimeter " + std::to_string(perimeter) + " mm in " + std::to_string(f.wings) +
                               " wings needs " + std::to_string(least_diameter) + " mm, crimped_diameter_mm is " +
                               std::to_string(spec.crimped_diameter),
                           "raise crimped_diameter_mm, or lower membrane_thickness_mm or shaft_diameter_mm");
}

FoldedSection folded_section(const BalloonSpec& spec, int ring_size) {
  return folded_section(*spec.folding, ring_size, unfolded_edge(spec, ring_size));
}

Vectors place_folded(const BalloonSpec& spec, const RingGrid& grid, const std::vector<Frame>& frames,
                     const std::vector<double>& largest_radius) {
  const FoldedSection section = folded_section(spec, grid.ring_size);
  Vectors points;
  for (int r = 0; r < grid.rings(); ++r) {
    const double needed_radius = grid.profile[r] * section.outer_radius;
    if (needed_radius > largest_radius[r] + 1e-9)
      throw common::ComputationError("a folded balloon does not fit where it is placed",
                                     "ring at " + std::to_string(grid.s[r]) + " mm from its centre",
                                     std::to_string(2 * needed_radius) + " mm wide, room for " +
                                         std::to_string(2 * largest_radius[r]) + " mm",
                                     "dilate first with a smaller balloon, fold it tighter (wings, "
                                     "membrane_thickness_mm), or leave folding off for it");
    for (const Vec2& p : section.points)
      points.push_back(frames[r].origin + grid.profile[r] * (p[0] * frames[r].first + p[1] * frames[r].second));
  }
  return points;
}

} // namespace vci
