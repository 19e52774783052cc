// What every force of the model offers: energy, force (minus its gradient) and stiffness (its Hessian).
#pragma once
#include "vci/block_matrix.hpp"

namespace vci {

/// Which part of the force balance a force belongs to (see residual in integrator.hpp).
enum class ForceKind { elastic, foundation, pressure };

class Force {
public:
  virtual ~Force() = default;
  virtual ForceKind kind() const { return ForceKind::elastic; }
  /// Energy in N mm at positions x (mm).
  virtual double energy(const Vectors& x) const = 0;
  /// Adds -dE/dx (N) to `force` and, where given, d2E/dx2 (N/mm) to `stiffness`, which must have been linked.
  /// With `exact` false, negative eigenvalues of the element Hessians are left out: the matrix stays positive.
  virtual void evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact = false) const = 0;
  /// Declares the pairs of vertices that interact.
  virtual void declare(BlockPattern& pattern) const = 0;
  /// Looks up where the pairs are stored.
  virtual void link(const BlockMatrix& matrix) = 0;
  /// Adds rate (1/ms) times the damping matrix (N ms/mm) of forces that have one; mass (g) per vertex.
  virtual void add_damping(const Vectors& x, const std::vector<double>& mass, double rate, BlockMatrix& matrix) const {
    (void)x, (void)mass, (void)rate, (void)matrix;
  }
  /// Makes plastic flow at x permanent.
  virtual void commit(const Vectors& x) { (void)x; }
};

/// Slots of a stencil's blocks, row by row.
template <std::size_t N> std::array<int, N * N> slots_of(const BlockMatrix& matrix, const std::array<int, N>& stencil) {
  std::array<int, N * N> slots;
  for (std::size_t i = 0; i < N; ++i)
    for (std::size_t j = 0; j < N; ++j)
      slots[N * i + j] = matrix.slot(stencil[i], stencil[j]);
  return slots;
}

} // namespace vci
