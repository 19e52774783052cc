// Shortens the displacements of single vertices that oscillate from step to step.
#pragma once
#include "vci/linalg/types.hpp"

#include <vector>

namespace vci {

/// Remembers, over the steps of one stage, which vertices oscillate. Displacements are in mm, one for each vertex.
class StepRelaxation {
public:
  /// Halves the displacements of single vertices that go back and forth. The step's length follows from the
  /// displacement that one vertex in a hundred exceeds. So a vertex that moves far more may oscillate for ever, as at a
  /// buckling balloon tip or an edge of calcium. Its force then dominates the linear solve. The displacement of such a
  /// vertex is halved as soon as it turns back. For other vertices this is done only after four turns in a row that
  /// do not decay. Fewer turns are harmless: the linear solves reduce their residual only to a fifth, so many vertices
  /// turn back a little.
  /// @param displacement the step as solved; shortened in place
  /// @param previous the displacement taken in the step before; with another number of vertices nothing is changed
  /// @param large_displacement the displacement that one vertex in a hundred exceeds
  void damp(Vectors& displacement, const Vectors& previous, double large_displacement);

private:
  std::vector<double> share_; ///< share of the solved displacement that each vertex takes
  std::vector<int> turns_;    ///< in how many steps in a row each vertex has turned back without decay
};

} // namespace vci
