#include "vci/devices/balloon/balloon.hpp"
#include "vci/devices/balloon/folding.hpp"
#include "vci/devices/balloon/hoop_chart.hpp"
#include "vci/mechanics/hinge.hpp"
#include "vci/mechanics/membrane.hpp"
#include "vci/mechanics/vertex_force.hpp"

#include <cmath>

namespace vci {

namespace {

constexpr double surface_density = 1.1e-3 * 0.1; // g/mm^2: folded nylon, 0.1 mm thick
constexpr double tip_diameter_ratio = 0.35;      // diameter of the balloon's welded ends over the nominal diameter
// Axial stiffness of the balloon's film per width at the nominal diameter, N/mm. The bending stiffness of the taut
// balloon is pi R^3 times this value. For an isotropic film the makers' charts would give (1 - nu/2) d(p R)/d ln R from
// nominal to rated burst pressure, with nu = 0.4. For balloons of 3 mm that is 14 (semi-compliant), 15 (delivery) or 43
// N/mm (non-compliant). The value here is lower, since polyamide-12 balloons are softer along than round their axis
// (Geith et al., PLoS ONE 15 (2020) e0234340), and since folds remain. measured.md tells how areas depend on the value.
constexpr double axial_stiffness = 8.0;
constexpr double hinge_coefficient = 0.002;     // N mm per edge: bending stiffness that keeps the grid from wrinkling
constexpr double crease_yield_angle = 0.02;     // rad: a folded balloon's limp film keeps creases that are sharper
constexpr double shaft_anchor_stiffness = 0.02; // N/mm: holds each vertex of the end rings at the catheter's shaft
constexpr double neck_anchor_stiffness = 0.4;   // N/mm: holds each end ring of a folded balloon, shared by its vertices
// A grid of fibres alone has no shear stiffness, so a weak film (0.3 N/mm, yielding at a strain of 0.05) is added.
constexpr HenckyLaw balloon_film{0.3, 0.3, 0.0, 0.05, 0.02};

} // namespace

RingGrid balloon_grid(const BalloonSpec& spec, double edge) {
  RingGrid g;
  g.ring_size = spec.folding ? folded_ring_size(spec, edge) : even_edge_count(pi * spec.nominal_diameter, edge);
  const double folded_ratio =
      spec.folding ? 2 * folded_section(spec, g.ring_size).outer_radius / spec.crimped_diameter : 1.0;
  const int body = std::max(2, static_cast<int>(std::lround(spec.length / edge)));
  const int cone = std::max(2, static_cast<int>(std::lround(spec.shoulder / edge)));
  const double tip = tip_diameter_ratio;
  const auto add = [&](double s, double profile) {
    g.s.push_back(s);
    g.profile.push_back(profile);
    g.start_ratio.push_back(folded_ratio * profile);
  };
  for (int k = 0; k < cone; ++k)
    add(-0.5 * spec.length - spec.shoulder * (cone - k) / cone, tip + (1 - tip) * std::sin(0.5 * pi * k / cone));
  for (int k = 0; k <= body; ++k)
    add(spec.length * (static_cast<double>(k) / body - 0.5), 1.0);
  for (int k = 1; k <= cone; ++k)
    add(0.5 * spec.length + spec.shoulder * k / cone, tip + (1 - tip) * std::sin(0.5 * pi * (cone - k) / cone));
  return g;
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
    hoops.push_back({first + e[0], first + e[1], width[e[0] / grid.ring_size], grid.profile[e[0] / grid.ring_size]});
  system.add_force(body, std::make_unique<HoopChart>(hoops, grid.ring_size, *chart));

  std::vector<Fibres::Fibre> axial;
  const double share = pi * spec.nominal_diameter / grid.ring_size;
  for (int r = 0; r + 1 < grid.rings(); ++r)
    for (int k = 0; k < grid.ring_size; ++k) {
      // Rest lengths are measured along the inflated balloon, whose radius changes along the shoulders.
      const double rise = 0.5 * spec.nominal_diameter * (grid.profile[r + 1] - grid.profile[r]);
      const double mean = 0.5 * (grid.profile[r] + grid.profile[r + 1]);
      axial.push_back({first + r * grid.ring_size + k, first + (r + 1) * grid.ring_size + k,
                       std::hypot(grid.s[r + 1] - grid.s[r], rise), axial_stiffness * share * mean, 0.0, true});
    }
  Fibres& fibres = system.add_force(body, std::make_unique<Fibres>(axial));
  Pressure& pressure = system.add_force(body, std::make_unique<Pressure>(system.body(body).triangles, system.x, 0.0));

  const Vectors rest = straight_grid(grid, 0.5 * (folded ? unfolded_diameter(spec) : spec.nominal_diameter));
  std::vector<InteriorEdge> edges = interior_edges(grid.triangles(), rest);
  const std::vector<double> coefficients = folded ? shell_coefficients(edges, rest, bending_rigidity(*spec.folding))
                                                  : std::vector<double>(edges.size(), hinge_coefficient);
  offset_vertices(edges, first);
  system.add_force(body, std::make_unique<Hinges>(edges, folded ? system.x : with_leading_zeros(rest, first),
                                                  coefficients, folded ? crease_yield_angle : 0.1));
  const Triangles& triangles = system.body(body).triangles;
  system.add_force(body, std::make_unique<Membrane>(triangles, folded ? with_leading_zeros(rest, first) : system.x,
                                                    std::vector<HenckyLaw>(triangles.size(), balloon_film)));
  std::vector<Anchors::Element> anchors;
  const double anchor_stiffness = folded ? neck_anchor_stiffness / grid.ring_size : shaft_anchor_stiffness;
  for (int k = 0; k < grid.ring_size; ++k)
    for (int v : {first + k, first + (grid.rings() - 1) * grid.ring_size + k})
      anchors.push_back({v, system.x[v], anchor_stiffness});
  system.add_force(body, std::make_unique<Anchors>(anchors));
  return {body, std::move(grid), &pressure, &fibres, chart};
}

void set_pressure(Balloon& balloon, double pressure_mpa) {
  balloon.pressure->set(pressure_mpa);
  const double d = balloon.chart->diameter_at(pressure_mpa);
  const double pull = pressure_mpa * pi * d * d / (4 * balloon.grid.ring_size);
  std::vector<double> pretension;
  for (int r = 0; r + 1 < balloon.grid.rings(); ++r) {
    const double mean = 0.5 * (balloon.grid.profile[r] + balloon.grid.profile[r + 1]);
    pretension.insert(pretension.end(), balloon.grid.ring_size,
                      pull * (mean * mean - tip_diameter_ratio * tip_diameter_ratio));
  }
  balloon.axial_fibres->set_pretension(pretension);
}

} // namespace vci
