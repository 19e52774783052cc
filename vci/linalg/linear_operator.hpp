// The matrix of a step in the layout that conjugate gradients read fastest: four numbers for each vector, in single or
// double precision.
#pragma once
#include "vci/linalg/block_matrix.hpp"
#include <algorithm>

namespace vci {

/// The stiffness of a contact or tie: k n n^T + k_t (I - n n^T) - s s^T, where n is the normal. It resists the weighted
/// sum of the displacements of up to four vertices. Contacts and ties change from step to step, so they are not in the
/// sparse pattern.
struct StencilStiffness {
  std::array<int, 4> vertex; ///< -1 marks an unused place
  std::array<double, 4> weight;
  Vec3 normal;
  double normal_stiffness;            ///< k, N/mm
  double tangential_stiffness;        ///< k_t, N/mm
  Vec3 slip_softening = Vec3::Zero(); ///< s, along the slip of a sliding contact, (N/mm)^(1/2)
  Mat3 stiffness() const {
    Mat3 k = (normal_stiffness - tangential_stiffness) * normal * normal.transpose();
    k.diagonal().array() += tangential_stiffness;
    return k - slip_softening * slip_softening.transpose();
  }
};

/// The sum of a block matrix, its rank-one terms and the stiffnesses of stencils, without the fixed vertices. Vectors
/// hold four numbers for each vertex, of which the last is 0.
template <class Real> class LinearOperator {
public:
  using PaddedVector = Eigen::Array<Real, 4, 1>;
  using Block = Eigen::Array<Real, 4, 3>;
  using Field = std::vector<PaddedVector>;

  LinearOperator(const BlockMatrix& matrix, const std::vector<StencilStiffness>& stencils,
                 const std::vector<char>& fixed)
      : matrix_(matrix), fixed_(fixed) {
    values_.resize(9 * static_cast<std::size_t>(matrix.entries()) + 1); // + 1: the last three are read as four
    for (int i = 0; i < matrix.rows(); ++i)
      for (int k = matrix.row_start(i); k < matrix.row_start(i + 1); ++k) {
        const double* a = matrix.block(matrix.entry_slot(k)).data();
        Real* stored = values_.data() + 9 * static_cast<std::ptrdiff_t>(k);
        if (k < matrix.diagonal_entry(i)) // below the diagonal
          for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r)
              stored[3 * c + r] = static_cast<Real>(a[3 * r + c]);
        else
          for (int e = 0; e < 9; ++e)
            stored[e] = static_cast<Real>(a[e]);
      }
    for (const StencilStiffness& stencil : stencils) {
      Stencil stored{stencil.vertex, {}, padded(stencil.stiffness())};
      for (int k = 0; k < 4; ++k) {
        stored.weight[k] = stencil.vertex[k] < 0 || fixed[stencil.vertex[k]] ? Real(0) : Real(stencil.weight[k]);
        stored.vertex[k] = std::max(stencil.vertex[k], 0);
      }
      stencils_.push_back(stored);
    }
    for (const RankOne& term : matrix.rank_ones()) {
      PaddedRankOne rank_one{{}, {}, Real(term.stiffness)};
      for (std::size_t k = 0; k < term.vertex.size(); ++k)
        if (!fixed[term.vertex[k]]) {
          rank_one.vertex.push_back(term.vertex[k]);
          rank_one.gradient.push_back(padded(term.gradient[k]));
        }
      rank_ones_.push_back(std::move(rank_one));
    }
  }

  static PaddedVector padded(const Vec3& v) { return PaddedVector(Real(v[0]), Real(v[1]), Real(v[2]), Real(0)); }
  static Block padded(const Mat3& m) {
    Block b = Block::Zero();
    b.template topRows<3>() = m.array().template cast<Real>();
    return b;
  }
  static PaddedVector product(const Block& a, const PaddedVector& x) {
    return a.col(0) * x[0] + a.col(1) * x[1] + a.col(2) * x[2];
  }

  /// y = A x. x must be 0 at fixed vertices; y is 0 there.
  void multiply(const Field& x, Field& y) const {
    for (int i = 0; i < matrix_.rows(); ++i) {
      PaddedVector sum = PaddedVector::Zero();
      if (!fixed_[i])
        for (int k = matrix_.row_start(i); k < matrix_.row_start(i + 1); ++k) {
          const Real* a = values_.data() + 9 * static_cast<std::ptrdiff_t>(k); // columns of three, each read as four
          const PaddedVector& v = x[matrix_.column(k)];
          sum += UnalignedMap(a) * v[0] + UnalignedMap(a + 3) * v[1] + UnalignedMap(a + 6) * v[2];
        }
      y[i] = sum;
      y[i][3] = 0;
    }
    for (const PaddedRankOne& rank_one : rank_ones_) {
      PaddedVector sum = PaddedVector::Zero();
      for (std::size_t k = 0; k < rank_one.vertex.size(); ++k)
        sum += rank_one.gradient[k] * x[rank_one.vertex[k]];
      const Real along = rank_one.stiffness * (sum[0] + sum[1] + sum[2]);
      for (std::size_t k = 0; k < rank_one.vertex.size(); ++k)
        y[rank_one.vertex[k]] += along * rank_one.gradient[k];
    }
    for (const Stencil& stencil : stencils_) {
      PaddedVector r = PaddedVector::Zero();
      for (int k = 0; k < 4; ++k)
        r += stencil.weight[k] * x[stencil.vertex[k]];
      const PaddedVector f = product(stencil.stiffness, r);
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
  struct PaddedRankOne {
    std::vector<int> vertex;
    Field gradient;
    Real stiffness;
  };
  using UnalignedMap = Eigen::Map<const PaddedVector>;
  const BlockMatrix& matrix_;
  const std::vector<char>& fixed_;
  std::vector<Real> values_; ///< nine numbers for each block, column by column
  std::vector<Stencil> stencils_;
  std::vector<PaddedRankOne> rank_ones_;
};

} // namespace vci
