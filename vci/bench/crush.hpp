// Radial strength of a stent on the bench: free expansion by its balloon, free recoil, crushing from outside.
#pragma once
#include "vci/devices/balloon/balloon_spec.hpp"
#include "vci/devices/stent/stent_spec.hpp"
#include "vci/scene/numerics.hpp"

namespace vci {

struct CrushPoint {
  double loss_percent, pressure_mpa; ///< loss in % of the mean diameter after recoil; outside pressure that causes it
};
struct CrushTest {
  double inflated_diameter, free_diameter; ///< mean over the rings, mm: on the inflated balloon, and after recoil
  double recoil_percent;
  double residual; ///< largest residual of all balanced states, relative to the applied forces
  std::vector<CrushPoint> points;
};

/// Expands a stent in air and takes the balloon out. A crimper then closes round the stent until the mean diameter has
/// fallen by 10 %. The crimper keeps the stent round, as the segmented head of a bench does. The pressure is the
/// crimper's total force divided by the free stent's outer area, interpolated between balanced states. During free
/// recoil a small outside pressure acts, a hundredth of the radial strength: the residual is relative to applied
/// forces, so there must be some. Throws common::ComputationError if a state does not reach force balance.
CrushTest crush(const StentSpec& stent, const BalloonSpec& balloon, const Numerics& numerics);

} // namespace vci
