#include "vci/linalg/coarse_space.hpp"

namespace vci {

namespace {

/// Lower half of a block matrix that is filled in any order.
class BlockAccumulator {
public:
  explicit BlockAccumulator(int rows) : rows_(rows) {}
  void add(int i, int j, const Mat3& block) {
    if (j > i)
      return;
    for (auto& [column, sum] : rows_[i])
      if (column == j) {
        sum += block;
        return;
      }
    rows_[i].emplace_back(j, block);
  }
  Eigen::SparseMatrix<double> matrix() const {
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t i = 0; i < rows_.size(); ++i)
      for (const auto& [j, block] : rows_[i])
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b)
            entries.emplace_back(3 * static_cast<int>(i) + a, 3 * j + b, block(a, b));
    const auto n = static_cast<Eigen::Index>(3 * rows_.size());
    Eigen::SparseMatrix<double> result(n, n);
    result.setFromTriplets(entries.begin(), entries.end());
    return result;
  }

private:
  std::vector<std::vector<std::pair<int, Mat3>>> rows_;
};

} // namespace

CoarseSpace::CoarseSpace(const BlockMatrix& matrix, const std::vector<StencilStiffness>& stencils,
                         const std::vector<char>& fixed, int patch_size) {
  assign_patches(matrix, fixed, patch_size);
  BlockAccumulator sum(patches_);
  for (int i = 0; i < matrix.rows(); ++i)
    for (int k = matrix.diagonal_entry(i); k < matrix.row_start(i + 1); ++k)
      if (const int j = matrix.column(k), p = patch_[i], q = patch_[j]; p >= 0 && q >= 0) {
        const Mat3& block = matrix.block(matrix.entry_slot(k));
        sum.add(p, q, block);
        if (j > i)
          sum.add(q, p, block.transpose());
      }
  for (const StencilStiffness& stencil : stencils) {
    const Mat3 stiffness = stencil.stiffness();
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b)
        if (stencil.vertex[a] >= 0 && stencil.vertex[b] >= 0)
          if (const int p = patch_[stencil.vertex[a]], q = patch_[stencil.vertex[b]]; p >= 0 && q >= 0 && q <= p)
            sum.add(p, q, stencil.weight[a] * stencil.weight[b] * stiffness);
  }
  for (const RankOne& term : matrix.rank_ones()) {
    std::vector<std::pair<int, Vec3>> gradient; // for each patch, the sum over its vertices
    for (std::size_t k = 0; k < term.vertex.size(); ++k) {
      const int p = patch_[term.vertex[k]];
      if (p < 0)
        continue;
      if (gradient.empty() || gradient.back().first != p)
        gradient.emplace_back(p, Vec3::Zero());
      gradient.back().second += term.gradient[k];
    }
    for (const auto& [p, g] : gradient)
      for (const auto& [q, h] : gradient)
        sum.add(p, q, term.stiffness * g * h.transpose());
  }
  if (patches_ == 0)
    return;
  factor_.compute(sum.matrix());
  usable_ = factor_.info() == Eigen::Success;
}

void CoarseSpace::assign_patches(const BlockMatrix& matrix, const std::vector<char>& fixed, int patch_size) {
  patch_.assign(fixed.size(), -1);
  std::vector<int> members;
  for (int seed = 0; seed < matrix.rows(); ++seed) {
    if (fixed[seed] || patch_[seed] >= 0)
      continue;
    members.assign(1, seed);
    patch_[seed] = patches_;
    for (std::size_t m = 0; m < members.size(); ++m)
      for (int k = matrix.row_start(members[m]); k < matrix.row_start(members[m] + 1); ++k) {
        const int v = matrix.column(k);
        if (static_cast<int>(members.size()) < patch_size && !fixed[v] && patch_[v] < 0) {
          patch_[v] = patches_;
          members.push_back(v);
        }
      }
    ++patches_;
  }
}

} // namespace vci
