// The matrix of a step in the layout that conjugate gradients read fastest: four numbers for each vector, in single or
// double precision.
#pragma once
#include "vci/linalg/block_matrix.hpp"
#include <algorithm>

namespace vci {

/// The stiffness of a contact or tie: k n n^T + k_t (I - n n^T) - s s^T against the weighted sum of the displacements
/// of up to four vertices. Contacts and ties change from step to step, so they are not in the sparse pattern.
struct StencilStiffness {
  std::array<int, 4> vertex; ///< -1 marks an unused place
  std::array<double, 4> weight;
  Vec3 normal;
  double normal_stiffness;     ///< k, N/mm
  double tangential_stiffness; ///< k_t, N/mm
  Vec3 sliding = Vec3::Zero(); ///< s, along the slip of a sliding contact, (N/mm)^(1/2)
  Mat3 stiffness() const {
    Mat3 k = (normal_stiffness - tangential_stiffness) * normal * normal.transpose();
    k.diagonal().array() += tangential_stiffness;
    return k - sliding * sliding.transpose();
  }
};

/// The sum of a block matrix, its rank-one terms and the stiffnesses of stencils, without the fixed vertices. Vectors
/// hold four numbers for each vertex, of which the last is 0.
template <class Real> class LinearOperator {
public:
  using Four = Eigen::Array<Real, 4, 1>;
  using Block = Eigen::Array<Real, 4, 3>;
  using Field = std::vector<Four>;

  LinearOperator(const BlockMatrix& matrix, const std::vector<StencilStiffness>& stencils,
                 const std::vector<char>& fixed)
      : matrix_(matrix), fixed_(fixed) {
    values_.resize(9 * static_cast<std::size_t>(matrix.entries()) + 1); // + 1, as a column is read as four numbers
    for (int i = 0; i < matrix.rows(); ++i)
      for (int k = matrix.row_start(i); k < matrix.row_start(i + 1); ++k) {
        const double* a = matrix.block(matrix.slot_of(k)).data();
        Real* own = values_.data() + 9 * static_cast<std::ptrdiff_t>(k);
        if (k < matrix.diagonal_entry(i)) // below the diagonal
          for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r)
              own[3 * c + r] = static_cast<Real>(a[3 * r + c]);
        else
          for (int e = 0; e < 9; ++e)
            own[e] = static_cast<Real>(a[e]);
      }
    for (const StencilStiffness& stencil : stencils) {
      Stencil own{stencil.vertex, {}, padded(stencil.stiffness())};
      for (int k = 0; k < 4; ++k) {
        own.weight[k] = stencil.vertex[k] < 0 || fixed[stencil.vertex[k]] ? Real(0) : Real(stencil.weight[k]);
        own.vertex[k] = std::max(stencil.vertex[k], 0);
      }
      stencils_.push_back(own);
    }
    for (const RankOne& term : matrix.rank_ones()) {
      Ring ring{{}, {}, Real(term.stiffness)};
      for (std::size_t k = 0; k < term.vertex.size(); ++k)
        if (!fixed[term.vertex[k]]) {
          ring.vertex.push_back(term.vertex[k]);
          ring.gradient.push_back(padded(term.gradient[k]));
        }
      rings_.push_back(std::move(ring));
    }
  }

  static Four padded(const Vec3& v) { return Four(Real(v[0]), Real(v[1]), Real(v[2]), Real(0)); }
  static Block padded(const Mat3& m) {
    Block b = Block::Zero();
    b.template topRows<3>() = m.array().template cast<Real>();
    return b;
  }
  static Four product(const Block& a, const Four& x) { return a.col(0) * x[0] + a.col(1) * x[1] + a.col(2) * x[2]; }

  /// y = A x. x must be 0 at fixed vertices; y is 0 there.
  void multiply(const Field& x, Field& y) const {
    for (int i = 0; i < matrix_.rows(); ++i) {
      Four sum = Four::Zero();
      if (!fixed_[i])
        for (int k = matrix_.row_start(i); k < matrix_.row_start(i + 1); ++k) {
          const Real* a = values_.data() + 9 * static_cast<std::ptrdiff_t>(k); // columns of three, each read as four
          const Four& v = x[matrix_.column(k)];
          sum += Loose(a) * v[0] + Loose(a + 3) * v[1] + Loose(a + 6) * v[2];
        }
      y[i] = sum;
      y[i][3] = 0;
    }
    for (const Ring& ring : rings_) {
      Four sum = Four::Zero();
      for (std::size_t k = 0; k < ring.vertex.size(); ++k)
        sum += ring.gradient[k] * x[ring.vertex[k]];
      const Real along = ring.stiffness * (sum[0] + sum[1] + sum[2]);
      for (std::size_t k = 0; k < ring.vertex.size(); ++k)
        y[ring.vertex[k]] += along * ring.gradient[k];
    }
    for (const Stencil& stencil : stencils_) {
      Four r = Four::Zero();
      for (int k = 0; k < 4; ++k)
        r += stencil.weight[k] * x[stencil.vertex[k]];
      const Four f = product(stencil.stiffness, r);
      for (int k = 0; k < 4; ++k)
        y[stencil.vertex[k]] += stencil.weight[k] * f;
    }
  }

private:
  struct Stencil {
    std::array<int, 4> vertex;
    std::array<Real, 4> weight;
    Block stiffness;
  };
  struct Ring {
    std::vector<int> vertex;
    Field gradient;
    Real stiffness;
  };
  using Loose = Eigen::Map<const Four>;
  const BlockMatrix& matrix_;
  const std::vector<char>& fixed_;
  std::vector<Real> values_; ///< nine numbers for each block, column by column
  std::vector<Stencil> stencils_;
  std::vector<Ring> rings_;
};

} // namespace vci
