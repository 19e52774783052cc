#include "vci/devices/stent/stent.hpp"
#include "vci/devices/stent/cell_shear.hpp"
#include "vci/devices/stent/ring_hoop.hpp"
#include "vci/mechanics/fibre.hpp"
#include "vci/mechanics/hinge.hpp"
#include "vci/mechanics/membrane.hpp"

#include <cmath>

namespace vci {

namespace {

constexpr double surface_density = 1.1e-3 * 0.1; // g/mm^2: struts, 0.1 mm thick
// Stiffness (N mm per edge) against bending of a ring in its plane, for struts of this thickness (mm). A strut has the
// bending stiffness E w t^3 / 12, with E = 235 GPa, w = 0.09 mm and t = 0.08 mm. Half of it counts, since struts run at
// an angle to the axis. One strut is assumed for each 1.2 mm of length.
constexpr double hinge_coefficient = 0.4, hinge_strut_thickness = 0.08;
// A grid of fibres alone has no shear stiffness, so a weak film (0.3 N/mm, yielding at a strain of 0.05) is added. It
// hardens more than a balloon's film.
constexpr HenckyLaw stent_film{0.3, 0.3, 0.0, 0.05, 0.1};
// Tension at which a crimped ring begins to open, over the ring's yield tension at the nominal diameter. At both
// diameters the struts' ends bend plastically. The tension is 2 M / (l cos a), with M the plastic moment of a strut, l
// its length and a its angle to the axis. For 16 struts of 1 mm round a ring, cos a falls from 0.98 at 1 mm to 0.81 at
// 3 mm. M grows with the flow stress of the alloy. L605 yields at 476 MPa and has a true strength of 1449 MPa at a
// strain of 0.4. At an assumed mean strain of 0.17 it bears about 890 MPa. So the ratio is 0.53 times 0.83. These
// figures of L605 are usual in finite-element studies; no paper is at hand. A bench curve of opening pressures should
// replace this estimate.
constexpr double crimped_tension_ratio = 0.44;
// Strength of RingEvenness, which keeps the edges of a ring equally long. It is the tension in an edge of nominal
// length that is e = 2.718 times as long as its neighbour, over the ring's yield tension.
constexpr double evenness_ratio = 2.0;

// Shear stiffness of a cell over the least stiffness needed, which is the ring's yield tension over twice the edge.
// With less, a ring folds in zigzag when it yields in compression. The struts of a real cell are far stiffer, so the
// ratio is above 1.
constexpr double cell_shear_ratio = 4.0;

// The balloon gets at least this share of a chart's pressure, for charts with pressures that do not open the stent.
constexpr double least_balloon_share = 0.2;

/// Increase of a ring's yield strain per logarithmic strain. The yield strain by the maker's recoil holds at the
/// nominal diameter. The crimped ring yields at a lower strain, and hardens by the difference while it opens.
double hoop_hardening(const StentSpec& spec) {
  return (1 - crimped_tension_ratio) * spec.yield_strain() / std::log(spec.nominal_diameter / spec.crimped_diameter);
}

/// Bending stiffness (N mm) of the hinges at the edges.
double hinge_stiffness(const StentSpec& spec) {
  // A free ring must not buckle below the maker's radial strength. By Levy it buckles at the pressure 3 EI / R^3, with
  // EI its bending stiffness per axial length.
  const double radius = 0.5 * spec.nominal_diameter;
  const double buckling_rigidity = spec.radial_strength_mpa * radius * radius * radius / 3;
  return std::max(buckling_rigidity, hinge_coefficient * std::pow(spec.strut_thickness / hinge_strut_thickness, 3));
}

/// Stiffness (N/mm) of the axial fibres. It gives the stent its bending stiffness, and is at least the stated axial
/// stiffness, which couples the rings.
///
/// A tube of radius R whose wall has the axial stiffness k bends with pi R^3 k. A part of k is the film's. A hinge at
/// an edge round the stent turns by the curvature times the spacing of the rings times the cosine of its angle round
/// the stent. So n hinges of stiffness c in each ring bend with n c / 2 times the spacing.
double fibre_stiffness(const StentSpec& spec, const RingGrid& grid) {
  const double radius = 0.5 * spec.nominal_diameter, spacing = spec.length / (grid.rings() - 1);
  const double of_hinges = 0.5 * grid.ring_size * hinge_stiffness(spec) * spacing;
  const double of_wall = (spec.bending_stiffness - of_hinges) / (pi * radius * radius * radius);
  return std::max(spec.axial_stiffness, of_wall - stent_film.stiffness);
}

} // namespace

double opening_pressure_mpa(const StentSpec& spec, double diameter) {
  const double yield_strain =
      crimped_tension_ratio * spec.yield_strain() + hoop_hardening(spec) * std::log(diameter / spec.crimped_diameter);
  return 2 * spec.hoop_stiffness() * yield_strain / diameter;
}

std::vector<double> pressures_without_stent(const StentSpec& spec, std::vector<double> pressure_bar,
                                            const std::vector<double>& diameter) {
  for (std::size_t k = 0; k < pressure_bar.size(); ++k) {
    const double of_balloon = pressure_bar[k] - opening_pressure_mpa(spec, diameter[k]) / mpa_per_bar;
    pressure_bar[k] = std::max(of_balloon, least_balloon_share * pressure_bar[k]);
  }
  return pressure_bar;
}

RingGrid stent_grid(const StentSpec& spec, double edge) {
  RingGrid g;
  g.ring_size = even_edge_count(pi * spec.nominal_diameter, edge);
  const int n = std::max(4, static_cast<int>(std::lround(spec.length / edge)));
  for (int k = 0; k <= n; ++k) {
    g.s.push_back(spec.length * (static_cast<double>(k) / n - 0.5));
    g.profile.push_back(1.0);
    g.start_ratio.push_back(1.0);
  }
  return g;
}

Stent add_stent(System& system, const StentSpec& spec, const std::string& device, RingGrid grid,
                const std::vector<Frame>& frames, const std::vector<double>& radius) {
  const Vectors points = place_grid(grid, frames, radius);
  const int first = system.vertices();
  const int body =
      system.add_body("stent", points, grid.triangles(), surface_density, std::vector<char>(points.size(), 0));
  const std::vector<double> width = ring_widths(grid);
  std::vector<RingHoops::Ring> hoops;
  std::vector<RingEvenness::Ring> evenness;
  for (int r = 0; r < grid.rings(); ++r) {
    RingHoops::Ring hoop{
        {}, spec.hoop_stiffness() * width[r], crimped_tension_ratio * spec.yield_strain(), hoop_hardening(spec)};
    for (int k = 0; k < grid.ring_size; ++k) {
      hoop.vertices.push_back(first + r * grid.ring_size + k);
      hoop.rest_length +=
          (points[r * grid.ring_size + (k + 1) % grid.ring_size] - points[r * grid.ring_size + k]).norm();
    }
    const double nominal_edge = pi * spec.nominal_diameter / grid.ring_size;
    evenness.push_back({hoop.vertices, evenness_ratio * spec.yield_strain() * hoop.stiffness * nominal_edge});
    hoops.push_back(std::move(hoop));
  }
  system.add_force(body, std::make_unique<RingHoops>(std::move(hoops)));
  system.add_force(body, std::make_unique<RingEvenness>(evenness));
  std::vector<CellShear::Cell> cells;
  for (int r = 0; r + 1 < grid.rings(); ++r)
    for (int k = 0; k < grid.ring_size; ++k) {
      const int a = first + r * grid.ring_size + k, b = first + r * grid.ring_size + (k + 1) % grid.ring_size;
      const double tension = spec.yield_strain() * spec.hoop_stiffness() * width[r];
      cells.push_back({{a, b, b + grid.ring_size, a + grid.ring_size},
                       cell_shear_ratio * tension / (2 * pi * spec.nominal_diameter / grid.ring_size)});
    }
  system.add_force(body, std::make_unique<CellShear>(cells));
  std::vector<Fibres::Fibre> fibres;
  const double share = pi * spec.nominal_diameter / grid.ring_size;
  for (int r = 0; r + 1 < grid.rings(); ++r)
    for (int k = 0; k < grid.ring_size; ++k)
      fibres.push_back({first + r * grid.ring_size + k, first + (r + 1) * grid.ring_size + k, grid.s[r + 1] - grid.s[r],
                        fibre_stiffness(spec, grid) * share});
  system.add_force(body, std::make_unique<Fibres>(fibres));
  const Vectors rest = straight_grid(grid, 0.5 * spec.nominal_diameter);
  std::vector<InteriorEdge> edges = interior_edges(grid.triangles(), rest);
  offset_vertices(edges, first);
  const std::vector<double> coefficients(edges.size(), hinge_stiffness(spec));
  system.add_force(body, std::make_unique<Hinges>(edges, with_leading_zeros(rest, first), coefficients, 0.1));
  const Triangles& triangles = system.body(body).triangles;
  system.add_force(
      body, std::make_unique<Membrane>(triangles, system.x, std::vector<HenckyLaw>(triangles.size(), stent_film)));
  return {body, std::move(grid), device};
}

} // namespace vci
