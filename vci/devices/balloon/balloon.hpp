// A balloon as a grid of rings along the vessel's axis, with its forces.
#pragma once
#include "vci/devices/balloon/balloon_chart.hpp"
#include "vci/devices/balloon/balloon_spec.hpp"
#include "vci/devices/ring_grid.hpp"
#include "vci/mechanics/fibre.hpp"
#include "vci/mechanics/pressure.hpp"

namespace vci {

RingGrid balloon_grid(const BalloonSpec& spec, double edge_mm);

/// A balloon in the system, with its pressure to be set.
struct Balloon {
  int body;
  RingGrid grid;
  Pressure* pressure;
  Fibres* axial;
  std::shared_ptr<const BalloonChart> chart;
};

/// @param radius of each ring at the start, mm; at most the crimped radius.
Balloon add_balloon(System& system, const BalloonSpec& spec, RingGrid grid, const std::vector<Frame>& frames,
                    const std::vector<double>& radius);
/// Sets the pressure and its axial pull on the fibres, p pi (D(p)^2 - tip^2) / 4 in all, since the open tips lie on the
/// shaft. With this pull the inflated balloon has the length that the maker states.
void set_pressure(Balloon& balloon, double pressure_mpa);

} // namespace vci
