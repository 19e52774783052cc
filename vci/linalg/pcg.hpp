// Filtered conjugate gradients (equation 12 of Lyu et al. 2025) with a preconditioner of two levels: 3x3 block Jacobi,
// and shifts of patches of vertices.
#pragma once
#include "vci/linalg/linear_operator.hpp"
#include <limits>
#include <memory>

namespace vci {

class CoarseSpace;

struct PcgSettings {
  double tolerance = 0.1; ///< norm of the residual over that of the right-hand side at which iterations end
  int maximal_iterations = 300;
  int patch_size = 0;            ///< largest number of vertices in a patch of the second level; 0: block Jacobi alone
  bool single_precision = false; ///< iterate in single precision, which suffices for tolerances of 1e-4 and more
  bool unpreconditioned = false; ///< no preconditioner at all
  /// A second tolerance, which must also be met. It is for the residual in the norm of the preconditioner, relative to
  /// the first residual. This norm approximates the energy of the error. The plain residual is dominated by a few
  /// vertices deep in contact.
  double preconditioned_tolerance = std::numeric_limits<double>::infinity();
};

/// The preconditioner's second level, kept for the next solves.
struct PreconditionerCache {
  std::shared_ptr<const CoarseSpace> coarse;
  int age = 0;              ///< number of solves that have used this second level
  int first_iterations = 0; ///< iterations of the solve for which the second level was made
};

struct SolveResult {
  bool converged;
  int iterations;
  double residual; ///< ||b - A x|| / ||b|| over the free vertices
};

/// Solves (A + stencils) x = b with x = 0 at fixed vertices, and returns the solution in x. If a search direction shows
/// that the matrix is not positive definite, the solver stops with `converged` false. Then x holds the last iterate or,
/// in the first iteration, the preconditioned right-hand side.
/// @param cache keeps the preconditioner's second level for the next call while the solves converge well; or null
SolveResult solve_pcg(const BlockMatrix& matrix, const std::vector<StencilStiffness>& stencils,
                      const std::vector<char>& fixed, const Vectors& right_hand_side, Vectors& x,
                      const PcgSettings& settings, PreconditionerCache* cache = nullptr);

} // namespace vci
