// A balloon before inflation: pleated into wings that are wrapped round the catheter's shaft.
#pragma once
#include "vci/devices/balloon/balloon_spec.hpp"
#include "vci/devices/ring_grid.hpp"

namespace vci {

/// Section of a folded balloon's body. Its perimeter is the unfolded balloon's, since the membrane hardly stretches.
/// The layers are arms of a spiral that rises by twice the membrane's thickness from one wing to the next. Each sector
/// goes from a valley on the shaft along a wing's back to its crest, and along its belly to the next valley.
/// Balloons folded in three: De Beule et al., J Biomech 41 (2008) 383; Mortier et al., J Biomech Eng 130 (2008) 021018.
struct FoldedSection {
  std::vector<Vec2>
      points;          ///< mm, counterclockwise, equally far apart; the first is a valley's middle. Empty: no wings
  double inner, outer; ///< distances of the nearest and the furthest vertex from the axis, mm
  double wrap;         ///< angle that a wing covers, rad
};
/// @param edge between neighbouring vertices, mm; @param around vertices, a multiple of twice the wings
FoldedSection folded_section(const FoldingSpec& folding, int around, double edge);
/// The section of a balloon by its chart, at pressure 0.
FoldedSection folded_section(const BalloonSpec& spec, int around);

/// Diameter (mm) of the balloon unfolded at pressure 0, to which the chart is continued.
double unfolded_diameter(const BalloonSpec& spec);

/// E t^3 / (12 (1 - nu^2)) of the membrane, N mm.
double bending_rigidity(const FoldingSpec& folding);

/// Number of vertices that a ring needs to follow the folds. Throws common::InputError if the perimeter does not fit
/// into the profile, or leaves no wings.
int vertices_round_folded(const BalloonSpec& spec, double edge_mm);

/// The vertices of a folded balloon on a vessel's axis. Along the cones the section is scaled down.
/// @param room radius that each ring may take, mm
/// Throws common::ComputationError if a ring does not fit.
Vectors place_folded(const BalloonSpec& spec, const RingGrid& grid, const std::vector<Frame>& frames,
                     const std::vector<double>& room);

} // namespace vci
