// A stent as a grid of rings along the vessel's axis, with its forces.
#pragma once
#include "vci/devices/ring_grid.hpp"
#include "vci/devices/stent/stent_spec.hpp"

namespace vci {

/// The rings of a stent, about `edge_mm` apart.
RingGrid stent_grid(const StentSpec& spec, double edge_mm);

/// Inside pressure (MPa) at which a free ring of the stent opens beyond this diameter (mm), by Laplace's law.
double opening_pressure_mpa(const StentSpec& spec, double diameter);

/// Pressures (bar) that open a delivery balloon alone to the diameters (mm) of its chart. Makers measure the chart of a
/// delivery system with the stent on the balloon, so the stent's opening pressure is subtracted.
std::vector<double> pressures_without_stent(const StentSpec& spec, std::vector<double> pressure_bar,
                                            const std::vector<double>& diameter);

/// A stent in the system.
struct Stent {
  int body; ///< number of the body in the system
  RingGrid grid;
  std::string device; ///< name of the device in the scene
};

/// Adds a stent with its forces to the system.
/// @param frames place and axes of each ring in the vessel
/// @param radius radius of each ring at the start, mm; at most the crimped radius
Stent add_stent(System& system, const StentSpec& spec, const std::string& device, RingGrid grid,
                const std::vector<Frame>& frames, const std::vector<double>& radius);

} // namespace vci
