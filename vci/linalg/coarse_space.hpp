// Second level of the preconditioner: patches of vertices that move together.
#pragma once
#include "vci/linalg/linear_operator.hpp"
#include <Eigen/SparseCholesky>

namespace vci {

/// The matrix restricted to displacements that shift each patch of neighbouring vertices as a whole (aggregation
/// without smoothing, Vanek et al. 1996). It corrects errors that are long waves along the vessel, or shifts of whole
/// devices, at once. Block Jacobi would need many iterations for them.
class CoarseSpace {
public:
  /// @param fixed whether each vertex is held in place; such vertices belong to no patch
  /// @param patch_size largest number of vertices in a patch
  CoarseSpace(const BlockMatrix& matrix, const std::vector<StencilStiffness>& stencils, const std::vector<char>& fixed,
              int patch_size);
  int patches() const { return patches_; }
  int vertices() const { return static_cast<int>(patch_.size()); }
  /// False if there are no patches or the coarse matrix is not positive definite. Then apply() must not be called.
  bool usable() const { return usable_; }
  /// z += P (P^T A P)^-1 P^T r, where P turns the shifts of the patches into displacements of their vertices.
  template <class Field> void apply(const Field& r, Field& z) const {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(3 * patches_);
    for (std::size_t i = 0; i < patch_.size(); ++i)
      if (patch_[i] >= 0)
        sum.segment<3>(3 * patch_[i]) += r[i].template head<3>().matrix().template cast<double>();
    const Eigen::VectorXd shift = factor_.solve(sum);
    using Real = typename Field::value_type::Scalar;
    for (std::size_t i = 0; i < patch_.size(); ++i)
      if (patch_[i] >= 0)
        z[i].template head<3>() += shift.segment<3>(3 * patch_[i]).template cast<Real>().array();
  }

private:
  void assign_patches(const BlockMatrix& matrix, const std::vector<char>& fixed, int patch_size);
  int patches_ = 0;
  bool usable_ = false;
  std::vector<int> patch_; ///< number of each vertex's patch, -1 for fixed vertices
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
};

} // namespace vci
