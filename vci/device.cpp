#include "vci/device.hpp"
#include "vci/cell_shear.hpp"
#include "vci/folding.hpp"
#include "vci/foundation.hpp"
#include "vci/hinge.hpp"
#include "vci/membrane.hpp"
#include "vci/ring_hoop.hpp"

#include <cmath>
#include <numbers>

namespace vci {

namespace {

constexpr double pi = std::numbers::pi;
constexpr double surface_density = 1.1e-3 * 0.1; // g/mm^2: folded nylon or struts, 0.1 mm thick
constexpr double tip_share = 0.35;               // of the nominal diameter, where the balloon's ends are welded
constexpr double balloon_axial_stiffness = 8.0;  // N/mm: thin nylon with residual folds
constexpr double balloon_hinge = 0.002;          // N mm per edge, keeps the grid from wrinkling
// N mm per edge: struts bending across the ring, E w t^3 / 12 for 235 GPa and 0.09 mm by 0.08 mm, half of it since
// struts run aslant, one of them for each 1.2 mm of length.
constexpr double stent_hinge = 0.4, stent_hinge_thickness = 0.08;
constexpr double crease_yield = 0.02; // rad per edge: the folded membrane is limp, its creases set and are ironed out
constexpr double shaft_anchor = 0.02; // N/mm per vertex of the end rings
constexpr double neck_hold = 0.4;     // N/mm per end ring of a folded balloon, whose rings have more vertices
// A grid of fibres alone has no shear stiffness: weak films give it, the stent's with more hardening.
constexpr HenckyLaw balloon_film{0.3, 0.3, 0.0, 0.05, 0.02};
constexpr HenckyLaw stent_film{0.3, 0.3, 0.0, 0.05, 0.1};
constexpr double hoop_hardening = 0.01;
// Tension that turns one edge e times as long as its neighbour, over the ring's yield tension.
constexpr double strut_evenness = 2.0;

// Shear stiffness of a cell over that at which a ring in compression at its yield folds in zigzag, tension over twice
// the edge: the struts of a cell are far stiffer than the ring is strong.
constexpr double cell_shear = 4.0;

int even_count(double circumference, double edge) {
  return 2 * std::max(6, static_cast<int>(std::lround(0.5 * circumference / edge)));
}

std::vector<std::array<int, 2>> hoop_edges(const RingGrid& g) {
  std::vector<std::array<int, 2>> edges;
  for (int r = 0; r < g.rings(); ++r)
    for (int k = 0; k < g.around; ++k)
      edges.push_back({r * g.around + k, r * g.around + (k + 1) % g.around});
  return edges;
}

/// Axial length that each ring stands for.
std::vector<double> ring_widths(const RingGrid& g) {
  std::vector<double> width(g.rings(), 0.0);
  for (int r = 0; r + 1 < g.rings(); ++r) {
    width[r] += 0.5 * (g.s[r + 1] - g.s[r]);
    width[r + 1] += 0.5 * (g.s[r + 1] - g.s[r]);
  }
  return width;
}

Vectors straight_grid(const RingGrid& g, double radius) {
  std::vector<Frame> frames;
  std::vector<double> radii;
  for (int r = 0; r < g.rings(); ++r) {
    frames.push_back({Vec3(0, 0, g.s[r]), Vec3::UnitZ(), Vec3::UnitX(), Vec3::UnitY()});
    radii.push_back(radius * g.profile[r]);
  }
  return place_grid(g, frames, radii);
}

void shift(std::vector<EdgePair>& edges, int first) {
  for (EdgePair& e : edges)
    for (int* v : {&e.e0, &e.e1, &e.w0, &e.w1})
      *v += first;
}

Vectors shifted(const Vectors& points, int first) {
  Vectors all(first, Vec3::Zero());
  all.insert(all.end(), points.begin(), points.end());
  return all;
}

} // namespace

Triangles RingGrid::triangles() const {
  Triangles list;
  for (int r = 0; r + 1 < rings(); ++r)
    for (int k = 0; k < around; ++k) {
      const int a = r * around + k, b = r * around + (k + 1) % around, c = a + around, d = b + around;
      if ((r + k) % 2 == 0) {
        list.push_back({a, b, d});
        list.push_back({a, d, c});
      } else {
        list.push_back({a, b, c});
        list.push_back({b, d, c});
      }
    }
  return list;
}

RingGrid balloon_grid(const BalloonSpec& spec, double edge) {
  RingGrid g;
  g.around = spec.folding ? vertices_round_folded(spec, edge) : even_count(pi * spec.nominal_diameter, edge);
  const double needs = spec.folding ? 2 * folded_section(spec, g.around).outer / spec.crimped_diameter : 1.0;
  const int body = std::max(2, static_cast<int>(std::lround(spec.length / edge)));
  const int cone = std::max(2, static_cast<int>(std::lround(spec.shoulder / edge)));
  const double tip = tip_share;
  const auto add = [&](double s, double profile) {
    g.s.push_back(s);
    g.profile.push_back(profile);
    g.start.push_back(needs * profile);
  };
  for (int k = 0; k < cone; ++k)
    add(-0.5 * spec.length - spec.shoulder * (cone - k) / cone, tip + (1 - tip) * std::sin(0.5 * pi * k / cone));
  for (int k = 0; k <= body; ++k)
    add(spec.length * (static_cast<double>(k) / body - 0.5), 1.0);
  for (int k = 1; k <= cone; ++k)
    add(0.5 * spec.length + spec.shoulder * k / cone, tip + (1 - tip) * std::sin(0.5 * pi * (cone - k) / cone));
  return g;
}

RingGrid stent_grid(const StentSpec& spec, double edge) {
  RingGrid g;
  g.around = even_count(pi * spec.nominal_diameter, edge);
  const int n = std::max(4, static_cast<int>(std::lround(spec.length / edge)));
  for (int k = 0; k <= n; ++k) {
    g.s.push_back(spec.length * (static_cast<double>(k) / n - 0.5));
    g.profile.push_back(1.0);
    g.start.push_back(1.0);
  }
  return g;
}

Vectors place_grid(const RingGrid& grid, const std::vector<Frame>& frames, const std::vector<double>& radius) {
  Vectors points;
  for (int r = 0; r < grid.rings(); ++r)
    for (int k = 0; k < grid.around; ++k) {
      const double angle = 2 * pi * k / grid.around;
      points.push_back(frames[r].origin +
                       radius[r] * (std::cos(angle) * frames[r].first + std::sin(angle) * frames[r].second));
    }
  return points;
}

Balloon add_balloon(System& system, const BalloonSpec& spec, RingGrid grid, const std::vector<Frame>& frames,
                    const std::vector<double>& radius) {
  const bool folded = spec.folding.has_value();
  const Vectors points = folded ? place_folded(spec, grid, frames, radius) : place_grid(grid, frames, radius);
  const int first = system.vertices();
  const int body =
      system.add_body("balloon", points, grid.triangles(), surface_density, std::vector<char>(points.size(), 0));
  std::vector<double> pressure_mpa = spec.chart_pressure_bar;
  for (double& p : pressure_mpa)
    p *= mpa_per_bar;
  auto chart = std::make_shared<const BalloonChart>(
      folded ? BalloonChart::of_unfolded(pressure_mpa, spec.chart_diameter)
             : BalloonChart(pressure_mpa, spec.chart_diameter, spec.crimped_diameter));

  const std::vector<double> width = ring_widths(grid);
  std::vector<HoopChart::Hoop> hoops;
  for (const auto& e : hoop_edges(grid))
    hoops.push_back({first + e[0], first + e[1], width[e[0] / grid.around], grid.profile[e[0] / grid.around]});
  system.add_force(body, std::make_unique<HoopChart>(hoops, grid.around, *chart));

  std::vector<Fibres::Fibre> axial;
  const double share = pi * spec.nominal_diameter / grid.around;
  for (int r = 0; r + 1 < grid.rings(); ++r)
    for (int k = 0; k < grid.around; ++k) {
      // the inflated profile's length, along its slope in the shoulders
      const double rise = 0.5 * spec.nominal_diameter * (grid.profile[r + 1] - grid.profile[r]);
      const double mean = 0.5 * (grid.profile[r] + grid.profile[r + 1]);
      axial.push_back({first + r * grid.around + k, first + (r + 1) * grid.around + k,
                       std::hypot(grid.s[r + 1] - grid.s[r], rise), balloon_axial_stiffness * share * mean, 0.0, true});
    }
  Fibres& fibres = system.add_force(body, std::make_unique<Fibres>(axial));
  Pressure& pressure = system.add_force(body, std::make_unique<Pressure>(system.body(body).triangles, system.x, 0.0));

  const Vectors rest = straight_grid(grid, 0.5 * (folded ? unfolded_diameter(spec) : spec.nominal_diameter));
  std::vector<EdgePair> edges = interior_edges(grid.triangles(), rest);
  const std::vector<double> coefficients = folded ? shell_coefficients(edges, rest, bending_rigidity(*spec.folding))
                                                  : std::vector<double>(edges.size(), balloon_hinge);
  shift(edges, first);
  system.add_force(body, std::make_unique<Hinges>(edges, folded ? system.x : shifted(rest, first), coefficients,
                                                  folded ? crease_yield : 0.1));
  const Triangles& triangles = system.body(body).triangles;
  system.add_force(body, std::make_unique<Membrane>(triangles, folded ? shifted(rest, first) : system.x,
                                                    std::vector<HenckyLaw>(triangles.size(), balloon_film)));
  std::vector<Anchors::Element> anchors;
  const double hold = folded ? neck_hold / grid.around : shaft_anchor;
  for (int k = 0; k < grid.around; ++k)
    for (int v : {first + k, first + (grid.rings() - 1) * grid.around + k})
      anchors.push_back({v, system.x[v], hold});
  system.add_force(body, std::make_unique<Anchors>(anchors));
  return {body, std::move(grid), &pressure, &fibres, chart};
}

void set_pressure(Balloon& balloon, double pressure_mpa) {
  balloon.pressure->set(pressure_mpa);
  const double d = balloon.chart->diameter_at(pressure_mpa);
  const double pull = pressure_mpa * pi * d * d / (4 * balloon.grid.around);
  std::vector<double> pretension;
  for (int r = 0; r + 1 < balloon.grid.rings(); ++r) {
    const double mean = 0.5 * (balloon.grid.profile[r] + balloon.grid.profile[r + 1]);
    pretension.insert(pretension.end(), balloon.grid.around, pull * (mean * mean - tip_share * tip_share));
  }
  balloon.axial->set_pretension(pretension);
}

Stent add_stent(System& system, const StentSpec& spec, const std::string& device, RingGrid grid,
                const std::vector<Frame>& frames, const std::vector<double>& radius) {
  const Vectors points = place_grid(grid, frames, radius);
  const int first = system.vertices();
  const int body =
      system.add_body("stent", points, grid.triangles(), surface_density, std::vector<char>(points.size(), 0));
  const std::vector<double> width = ring_widths(grid);
  // hardened on the way to its nominal diameter, the stent yields there at the strain stated
  const double first_yield =
      std::max(0.2 * spec.yield_strain,
               spec.yield_strain - hoop_hardening * std::log(spec.nominal_diameter / spec.crimped_diameter));
  std::vector<RingHoops::Ring> hoops;
  std::vector<RingEvenness::Ring> even;
  for (int r = 0; r < grid.rings(); ++r) {
    RingHoops::Ring hoop{{}, spec.hoop_stiffness * width[r], first_yield, hoop_hardening};
    for (int k = 0; k < grid.around; ++k) {
      hoop.vertices.push_back(first + r * grid.around + k);
      hoop.rest_length += (points[r * grid.around + (k + 1) % grid.around] - points[r * grid.around + k]).norm();
    }
    const double nominal_edge = pi * spec.nominal_diameter / grid.around;
    even.push_back({hoop.vertices, strut_evenness * spec.yield_strain * hoop.stiffness * nominal_edge});
    hoops.push_back(std::move(hoop));
  }
  system.add_force(body, std::make_unique<RingHoops>(std::move(hoops)));
  system.add_force(body, std::make_unique<RingEvenness>(even));
  std::vector<CellShear::Cell> cells;
  for (int r = 0; r + 1 < grid.rings(); ++r)
    for (int k = 0; k < grid.around; ++k) {
      const int a = first + r * grid.around + k, b = first + r * grid.around + (k + 1) % grid.around;
      const double tension = spec.yield_strain * spec.hoop_stiffness * width[r];
      cells.push_back({{a, b, b + grid.around, a + grid.around},
                       cell_shear * tension / (2 * pi * spec.nominal_diameter / grid.around)});
    }
  system.add_force(body, std::make_unique<CellShear>(cells));
  std::vector<Fibres::Fibre> fibres;
  const double share = pi * spec.nominal_diameter / grid.around;
  for (int r = 0; r + 1 < grid.rings(); ++r)
    for (int k = 0; k < grid.around; ++k)
      fibres.push_back({first + r * grid.around + k, first + (r + 1) * grid.around + k, grid.s[r + 1] - grid.s[r],
                        spec.axial_stiffness * share});
  system.add_force(body, std::make_unique<Fibres>(fibres));
  const Vectors rest = straight_grid(grid, 0.5 * spec.nominal_diameter);
  std::vector<EdgePair> edges = interior_edges(grid.triangles(), rest);
  shift(edges, first);
  // Bent as a beam, the axial fibres give pi R^3 k; hinges at the ring edges, turning by curvature times spacing times
  // the cosine round the ring, give the rest of the stent's bending stiffness.
  const double half = 0.5 * spec.nominal_diameter, spacing = spec.length / (grid.rings() - 1);
  const double by_fibres = pi * half * half * half * spec.axial_stiffness;
  const double ring_hinge = 2 * std::max(0.0, spec.bending_stiffness - by_fibres) / (grid.around * spacing);
  const double across = stent_hinge * std::pow(spec.strut_thickness / stent_hinge_thickness, 3);
  std::vector<double> coefficients;
  for (const EdgePair& e : edges) {
    const bool on_ring = (e.e0 - first) / grid.around == (e.e1 - first) / grid.around;
    coefficients.push_back(on_ring ? std::max(ring_hinge, across) : across);
  }
  system.add_force(body, std::make_unique<Hinges>(edges, shifted(rest, first), coefficients, 0.1));
  const Triangles& triangles = system.body(body).triangles;
  system.add_force(
      body, std::make_unique<Membrane>(triangles, system.x, std::vector<HenckyLaw>(triangles.size(), stent_film)));
  return {body, std::move(grid), device};
}

Vectors ring_centres(const System& system, int body, const RingGrid& grid) {
  Vectors centres;
  const int first = system.body(body).first;
  for (int r = 0; r < grid.rings(); ++r) {
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < grid.around; ++k)
      sum += system.x[first + r * grid.around + k];
    centres.push_back(sum / grid.around);
  }
  return centres;
}

std::vector<double> ring_radii(const System& system, int body, const RingGrid& grid) {
  const Vectors centres = ring_centres(system, body, grid);
  const int first = system.body(body).first;
  std::vector<double> radii;
  for (int r = 0; r < grid.rings(); ++r) {
    Vec3 area = Vec3::Zero();
    for (int k = 0; k < grid.around; ++k)
      area += 0.5 * (system.x[first + r * grid.around + k] - centres[r])
                        .cross(system.x[first + r * grid.around + (k + 1) % grid.around] - centres[r]);
    radii.push_back(std::sqrt(2 * area.norm() / (grid.around * std::sin(2 * pi / grid.around))));
  }
  return radii;
}

} // namespace vci
