// The interface of every force of the model: energy, force (minus its gradient) and stiffness (its Hessian).
#pragma once
#include "vci/linalg/block_matrix.hpp"
#include <algorithm>

namespace vci {

/// The part of the force balance to which a force belongs (see relax() in vci/solver/integrator.hpp).
enum class ForceKind { elastic, foundation, pressure };

class Force {
public:
  virtual ~Force() = default;
  virtual ForceKind kind() const { return ForceKind::elastic; }
  /// Energy in N mm at positions x (mm).
  virtual double energy(const Vectors& x) const = 0;
  /// Adds -dE/dx (N) to `force` and, if given, d2E/dx2 (N/mm) to `stiffness`, the matrix of the last locate_blocks().
  /// With `exact` false, negative eigenvalues of element Hessians are left out, so that the matrix stays positive. Some
  /// forces leave out a part also if `exact` is true, such as the turning of a hinge; their headers name it.
  virtual void evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact = false) const = 0;
  /// Declares the pairs of vertices that interact, so that the matrix gets blocks for them.
  virtual void declare_stencils(BlockPattern& pattern) const = 0;
  /// Looks up where the matrix stores the blocks of these pairs.
  virtual void locate_blocks(const BlockMatrix& matrix) = 0;
  /// Adds rate (1/ms) times the force's damping matrix (N ms/mm), if there is one.
  /// @param mass mass of each vertex, g
  virtual void add_damping(const Vectors& x, const std::vector<double>& mass, double rate, BlockMatrix& matrix) const {
    (void)x, (void)mass, (void)rate, (void)matrix;
  }
  /// Makes plastic flow at x permanent.
  virtual void commit(const Vectors& x) { (void)x; }
  /// Whether the displacements dx (mm) reverse a plastic flow by more than the elastic strain, although the stiffness
  /// was computed for continued flow. If so, the next call of evaluate() gives the elastic stiffness.
  virtual bool stop_reversed_flow(const Vectors& x, const Vectors& dx) {
    (void)x, (void)dx;
    return false;
  }
};

/// Where the matrix stores the 3x3 blocks of an element of N vertices (its stencil). The matrix stores only its upper
/// half.
template <std::size_t N> class StencilSlots {
public:
  StencilSlots() = default;
  StencilSlots(const BlockMatrix& matrix, const std::array<int, N>& stencil) {
    for (std::size_t i = 0; i < N; ++i)
      order_[i] = static_cast<int>(i);
    std::sort(order_.begin(), order_.end(), [&](int a, int b) { return stencil[a] < stencil[b]; });
    std::size_t k = 0;
    for (std::size_t i = 0; i < N; ++i)
      for (std::size_t j = i; j < N; ++j)
        slot_[k++] = matrix.slot(stencil[order_[i]], stencil[order_[j]]);
  }
  /// The element's local vertex numbers (0 to N - 1), in ascending order of their vertices in the system.
  const std::array<int, N>& order() const { return order_; }
  /// Adds block(a, b) for each pair of local numbers a, b for which a's vertex does not come after b's in the system.
  template <class Block> void add(BlockMatrix& matrix, const Block& block) const {
    std::size_t k = 0;
    for (std::size_t i = 0; i < N; ++i)
      for (std::size_t j = i; j < N; ++j)
        matrix.block(slot_[k++]).noalias() += block(order_[i], order_[j]);
  }
  /// Adds blocks that are already in the order of order(). Blocks of the lower half are ignored.
  void add_upper(BlockMatrix& matrix, const Mat3 (&block)[N][N]) const {
    std::size_t k = 0;
    for (std::size_t i = 0; i < N; ++i)
      for (std::size_t j = i; j < N; ++j)
        matrix.block(slot_[k++]) += block[i][j];
  }
  /// Adds c g g^T, where g has a vector for each of the element's vertices.
  void add_rank_one(BlockMatrix& matrix, double c, const std::array<Vec3, N>& g) const {
    std::size_t k = 0;
    for (std::size_t i = 0; i < N; ++i) {
      const Vec3 scaled = c * g[order_[i]];
      for (std::size_t j = i; j < N; ++j)
        matrix.block(slot_[k++]).noalias() += scaled * g[order_[j]].transpose();
    }
  }

private:
  std::array<int, N> order_{};
  std::array<int, N*(N + 1) / 2> slot_{};
};

} // namespace vci
