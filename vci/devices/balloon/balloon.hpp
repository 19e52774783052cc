// A balloon as a grid of rings along the vessel's axis, with its forces.
#pragma once
#include "vci/devices/balloon/balloon_chart.hpp"
#include "vci/devices/balloon/balloon_spec.hpp"
#include "vci/devices/ring_grid.hpp"
#include "vci/mechanics/fibre.hpp"
#include "vci/mechanics/pressure.hpp"

namespace vci {

/// The rings of a balloon's body and shoulders, about `edge_mm` apart.
RingGrid balloon_grid(const BalloonSpec& spec, double edge_mm);

/// A balloon in the system, and the forces that set_pressure() changes.
struct Balloon {
  int body; ///< number of the body in the system
  RingGrid grid;
  Pressure* pressure;
  Fibres* axial_fibres;
  std::shared_ptr<const BalloonChart> chart;
};

/// Adds a balloon with its forces to the system, without pressure.
/// @param frames place and axes of each ring in the vessel
/// @param radius radius of each ring at the start, mm; at most the crimped radius. A folded balloon must fit into it.
Balloon add_balloon(System& system, const BalloonSpec& spec, RingGrid grid, const std::vector<Frame>& frames,
                    const std::vector<double>& radius);
/// Sets the pressure p and the axial tension that it causes in the balloon's fibres. At a cross-section of diameter D
/// all fibres together bear p pi (D^2 - tip^2) / 4, since the tips are open and lie on the shaft. With this tension the
/// inflated balloon has the length that the maker states.
void set_pressure(Balloon& balloon, double pressure_mpa);

} // namespace vci
