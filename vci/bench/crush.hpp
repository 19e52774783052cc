// Radial strength of a stent on the bench: free expansion by its balloon, free recoil, crushing from outside.
#pragma once
#include "vci/devices/balloon/balloon_spec.hpp"
#include "vci/devices/stent/stent_spec.hpp"
#include "vci/scene/numerics.hpp"

namespace vci {

struct CrushPoint {
  double loss_percent, pressure_mpa; ///< of the mean diameter after recoil; outside pressure at which it is reached
};
struct CrushTest {
  double inflated_diameter, free_diameter; ///< mean over the rings, mm: balloon at its nominal diameter, and taken out
  double recoil_percent;
  double residual; ///< largest of all states in balance
  std::vector<CrushPoint> points;
};

/// Expands a stent in air, takes the balloon out and closes a crimper round it, until the mean diameter has fallen by
/// 10 %. The crimper is a radial penalty outside a shrinking radius. It keeps the stent round, as the segmented head of
/// a bench does. The pressure is the crimper's whole force over the stent's outside as it was when free; between states
/// it is interpolated. The free state is balanced under a hundredth of the radial strength from outside, since a
/// residual needs an applied force. Throws common::ComputationError where a state does not reach force balance.
CrushTest crush(const StentSpec& stent, const BalloonSpec& balloon, const Numerics& numerics);

} // namespace vci
