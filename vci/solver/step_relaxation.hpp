// Shortens the displacements of single vertices that oscillate from step to step.
#pragma once
#include "vci/linalg/types.hpp"

#include <vector>

namespace vci {

/// Steps of one stage towards balance. All displacements in mm, per vertex.
class StepRelaxation {
public:
  /// Halves the displacements of single vertices that go back and forth. The length of a step follows the displacement
  /// that one vertex in a hundred exceeds. A vertex that exceeds it by far may oscillate for ever, as at a buckling
  /// balloon tip or an edge of calcium, and its force then dominates the linear solve. It is halved as soon as it turns
  /// back. Other vertices are halved once they have turned back in several steps running. A single turn does no harm:
  /// the linear solves reduce their residual to a fifth only, so many vertices turn back a little.
  /// @param displacement the step as solved; shortened in place
  /// @param last the displacement taken in the step before; with another number of vertices nothing is changed
  /// @param typical the displacement that one vertex in a hundred exceeds
  void damp(Vectors& displacement, const Vectors& last, double typical);

private:
  std::vector<double> share_; ///< share of its displacement that each vertex takes
  std::vector<int> turns_;    ///< how many steps running each vertex has turned back
};

} // namespace vci
