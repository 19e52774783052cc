// A balloon before inflation: pleated into wings that are wrapped round the catheter's shaft.
#pragma once
#include "vci/devices/balloon/balloon_spec.hpp"
#include "vci/devices/ring_grid.hpp"

namespace vci {

/// Cross-section of a folded balloon's body. Its perimeter is that of the unfolded balloon, since the membrane hardly
/// stretches. The layers are arms of a spiral that rises by twice the membrane's thickness from one wing to the next.
/// The membrane goes from a valley on the shaft along a wing's back to its crest, then along the wing's belly to the
/// next valley. Balloons folded in three: De Beule et al., J Biomech 41 (2008) 383; Mortier et al., J Biomech Eng 130
/// (2008) 021018.
struct FoldedSection {
  /// Vertices (mm), counterclockwise, equally far apart; first the middle of a valley. Empty: too few edges for wings.
  std::vector<Vec2> points;
  double inner_radius, outer_radius; ///< distances of the nearest and the furthest vertex from the axis, mm
};
/// @param ring_size number of vertices, a multiple of twice the number of wings
/// @param edge distance between neighbouring vertices, mm
FoldedSection folded_section(const FoldingSpec& folding, int ring_size, double edge);
/// The cross-section of a folded balloon whose unfolded perimeter follows from its chart at pressure 0.
FoldedSection folded_section(const BalloonSpec& spec, int ring_size);

/// Diameter (mm) of the unfolded balloon at pressure 0. The chart is continued to this pressure with its first slope.
double unfolded_diameter(const BalloonSpec& spec);

/// Bending rigidity E t^3 / (12 (1 - nu^2)) of the membrane, N mm.
double bending_rigidity(const FoldingSpec& folding);

/// Number of vertices that a ring needs to follow the folds. Throws common::InputError if the folded perimeter does not
/// fit into the crimped diameter, or is too short for wings.
int folded_ring_size(const BalloonSpec& spec, double edge_mm);

/// The vertices (mm) of a folded balloon on a vessel's axis. Along the shoulders the section is scaled down.
/// @param largest_radius largest radius that each ring may have, mm
/// Throws common::ComputationError if a ring does not fit.
Vectors place_folded(const BalloonSpec& spec, const RingGrid& grid, const std::vector<Frame>& frames,
                     const std::vector<double>& largest_radius);

} // namespace vci
