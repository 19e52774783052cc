// What is taken of a step's solution where vertices jump to and fro.
#pragma once
#include "vci/linalg/types.hpp"

#include <vector>

namespace vci {

/// Steps of one stage towards balance. All displacements in mm, per vertex.
class StepRelaxation {
public:
  /// Halves the displacements of single vertices that go back and forth. The step's length follows what one vertex in a
  /// hundred exceeds; some that exceed it by far may jump to and fro for ever (a balloon's tip that buckles, a vertex
  /// at an edge of calcium), and their forces are all that conjugate gradients then look at. Others
  /// are halved once they have turned back several times running: solved to a fifth, many turn back a little without
  /// harm.
  /// @param displacement of the step as solved, is shortened
  /// @param last the displacement taken in the step before; of another size, or none: nothing is changed
  /// @param typical the displacement that one vertex in a hundred exceeds
  void calm(Vectors& displacement, const Vectors& last, double typical);

private:
  std::vector<double> share_; ///< of its displacement that each vertex takes
  std::vector<int> turns_;    ///< how many steps running each vertex has turned back
};

} // namespace vci
