// Balloons and stents: grids of rings along the vessel's axis, with their forces.
#pragma once
#include "vci/centreline.hpp"
#include "vci/fibre.hpp"
#include "vci/pressure.hpp"
#include "vci/scene.hpp"

namespace vci {

/// Rings of `around` vertices each; vertex (ring, k) is ring * around + k.
struct RingGrid {
  int around = 0;
  std::vector<double> s;       ///< along the straight device, from its centre, mm
  std::vector<double> profile; ///< share of the body's diameter
  std::vector<double> start;   ///< share of the crimped diameter that it needs at the start
  int rings() const { return static_cast<int>(s.size()); }
  Triangles triangles() const; ///< outward
};
RingGrid balloon_grid(const BalloonSpec& spec, double edge_mm);
RingGrid stent_grid(const StentSpec& spec, double edge_mm);

/// Vertices of a grid with the given radius at each ring.
Vectors place_grid(const RingGrid& grid, const std::vector<Frame>& frames, const std::vector<double>& radius);

/// A balloon in the system, with its pressure to be set.
struct Balloon {
  int body;
  RingGrid grid;
  Pressure* pressure;
  Fibres* axial;
  std::shared_ptr<const BalloonChart> chart;
};
struct Stent {
  int body;
  RingGrid grid;
  std::string device;
};

/// @param radius of each ring at the start, mm; at most the crimped one.
Balloon add_balloon(System& system, const BalloonSpec& spec, RingGrid grid, const std::vector<Frame>& frames,
                    const std::vector<double>& radius);
/// Pressure and the pull that it puts on the balloon's axial fibres, p pi (D(p)^2 - tip^2) / 4 in all (its open tips
/// lie on the shaft): the length that the maker states is the inflated one.
void set_pressure(Balloon& balloon, double pressure_mpa);
Stent add_stent(System& system, const StentSpec& spec, const std::string& device, RingGrid grid,
                const std::vector<Frame>& frames, const std::vector<double>& radius);

/// Mean radius (mm) of each ring about its own centre, from the area its polygon encloses.
std::vector<double> ring_radii(const System& system, int body, const RingGrid& grid);
Vectors ring_centres(const System& system, int body, const RingGrid& grid);

} // namespace vci
