// Filtered conjugate gradients (eq 12) with a 3x3 block-Jacobi preconditioner.
#pragma once
#include "vci/block_matrix.hpp"

namespace vci {

/// A stiffness k n n^T + k_t (I - n n^T) on a weighted sum of up to four vertices: contacts and ties, kept out of the
/// sparse pattern because they come and go.
struct PointLink {
  std::array<int, 4> vertex; ///< -1 marks an unused place
  std::array<double, 4> weight;
  Vec3 normal;
  double normal_stiffness;     ///< N/mm
  double tangential_stiffness; ///< N/mm
};

struct SolveResult {
  bool converged;
  int iterations;
  double residual; ///< ||b - A x|| / ||b|| over the free vertices
};

/// Solves (A + links) x = b with x = 0 at fixed vertices; x enters as zero and leaves as the solution.
/// @param relative_tolerance on the residual; @param maximal_iterations after which converged is false.
SolveResult solve_pcg(const BlockMatrix& matrix, const std::vector<PointLink>& links, const std::vector<char>& fixed,
                      const Vectors& right_hand_side, Vectors& x, double relative_tolerance, int maximal_iterations);

} // namespace vci
