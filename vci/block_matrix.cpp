#include "vci/block_matrix.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace vci {

BlockMatrix::BlockMatrix(BlockPattern pattern) {
  auto& columns = pattern.columns();
  const int n = static_cast<int>(columns.size());
  start_.assign(1, 0);
  for (int i = 0; i < n; ++i) {
    columns[i].push_back(i);
    std::sort(columns[i].begin(), columns[i].end());
    columns[i].erase(std::unique(columns[i].begin(), columns[i].end()), columns[i].end());
    column_.insert(column_.end(), columns[i].begin(), columns[i].end());
    start_.push_back(static_cast<int>(column_.size()));
  }
  values_.assign(column_.size(), Mat3::Zero());
  diagonal_.resize(n);
  for (int i = 0; i < n; ++i)
    diagonal_[i] = slot(i, i);
}

int BlockMatrix::slot(int i, int j) const {
  const auto first = column_.begin() + start_[i], last = column_.begin() + start_[i + 1];
  const auto it = std::lower_bound(first, last, j);
  if (it == last || *it != j)
    throw std::logic_error("block (" + std::to_string(i) + ", " + std::to_string(j) + ") is not in the pattern");
  return static_cast<int>(it - column_.begin());
}

void BlockMatrix::set_zero() {
  std::fill(values_.begin(), values_.end(), Mat3::Zero());
  rank_ones_.clear();
}

void BlockMatrix::multiply(const Vectors& x, Vectors& y) const {
  const int n = rows();
  for (int i = 0; i < n; ++i) {
    double s0 = 0, s1 = 0, s2 = 0;
    for (int k = start_[i]; k < start_[i + 1]; ++k) {
      const double* a = values_[k].data(); // column-major
      const double* v = x[column_[k]].data();
      s0 += a[0] * v[0] + a[3] * v[1] + a[6] * v[2];
      s1 += a[1] * v[0] + a[4] * v[1] + a[7] * v[2];
      s2 += a[2] * v[0] + a[5] * v[1] + a[8] * v[2];
    }
    y[i] = Vec3(s0, s1, s2);
  }
  for (const RankOne& term : rank_ones_) {
    double along = 0;
    for (std::size_t k = 0; k < term.vertex.size(); ++k)
      along += term.gradient[k].dot(x[term.vertex[k]]);
    for (std::size_t k = 0; k < term.vertex.size(); ++k)
      y[term.vertex[k]] += term.stiffness * along * term.gradient[k];
  }
}

} // namespace vci
