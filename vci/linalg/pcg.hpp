// Filtered conjugate gradients (eq 12) with a two-level preconditioner: 3x3 block Jacobi and shifts of patches.
#pragma once
#include "vci/linalg/linear_operator.hpp"
#include <limits>
#include <memory>

namespace vci {

class CoarseSpace;

struct PcgSettings {
  double tolerance = 0.1; ///< of the residual, relative to the right-hand side
  int maximal_iterations = 300;
  int patch_size = 0;            ///< vertices in a patch of the second level; 0: block Jacobi alone
  bool single_precision = false; ///< of the iterations; enough for tolerances of 1e-4 and more
  bool plain = false;            ///< no preconditioner at all
  /// A second tolerance, for the residual in the norm of the preconditioner, which approximates the energy of the
  /// error. Both must be met. A few vertices deep in contact dominate the plain residual.
  double preconditioned_tolerance = std::numeric_limits<double>::infinity();
};

/// The second level of earlier solves, used again while the matrix changes little.
struct PcgMemory {
  std::shared_ptr<const CoarseSpace> coarse;
  int age = 0;
  int first_iterations = 0; ///< of the solve for which it was made
};

struct SolveResult {
  bool converged;
  int iterations;
  double residual; ///< ||b - A x|| / ||b|| over the free vertices
};

/// Solves (A + stencils) x = b with x = 0 at fixed vertices, and returns the solution in x. The solver stops with
/// converged false if a search direction shows that the matrix is not positive definite. Then x holds the last iterate,
/// or, if that happens in the first iteration, the preconditioned right-hand side.
/// @param memory keeps the preconditioner's second level for the next call while the solves converge well; or null
SolveResult solve_pcg(const BlockMatrix& matrix, const std::vector<StencilStiffness>& stencils,
                      const std::vector<char>& fixed, const Vectors& right_hand_side, Vectors& x,
                      const PcgSettings& settings, PcgMemory* memory = nullptr);

} // namespace vci
