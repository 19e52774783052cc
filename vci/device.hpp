// Balloons and stents: grids of rings along the vessel's axis, with their forces.
#pragma once
#include "vci/fibre.hpp"
#include "vci/pressure.hpp"
#include "vci/ring_grid.hpp"
#include "vci/scene.hpp"

namespace vci {

RingGrid balloon_grid(const BalloonSpec& spec, double edge_mm);
RingGrid stent_grid(const StentSpec& spec, double edge_mm);

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

} // namespace vci
