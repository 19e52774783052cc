// Radial strength of a stent on the bench: free expansion by its balloon, free recoil, crushing from outside.
#pragma once
#include "vci/devices/balloon/balloon_spec.hpp"
#include "vci/devices/stent/stent_spec.hpp"
#include "vci/scene/numerics.hpp"

namespace vci {

struct CrushPoint {
  double loss_percent, pressure_mpa; ///< loss of mean diameter, of that after recoil; outside pressure that causes it
};
struct CrushTest {
  double inflated_diameter, free_diameter; ///< mean over the rings, mm: with the inflated balloon, and without it
  double recoil_percent;
  double residual; ///< largest of all balanced states, relative to the applied forces
  std::vector<CrushPoint> points;
};

/// Expands a stent in air, takes the balloon out and closes a crimper round the stent, until the mean diameter has
/// fallen by 10 %. The crimper pushes vertices back that lie outside a shrinking radius. It keeps the stent round, as
/// the segmented head of a bench does. The pressure is the crimper's total force over the outer area of the free stent,
/// interpolated between balanced states. The free stent is balanced under an outside pressure of a hundredth of its
/// radial strength, since the residual is relative to applied forces. Throws common::ComputationError if a state does
/// not reach force balance.
CrushTest crush(const StentSpec& stent, const BalloonSpec& balloon, const Numerics& numerics);

} // namespace vci
