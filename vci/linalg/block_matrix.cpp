#include "vci/linalg/block_matrix.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace vci {

BlockMatrix::BlockMatrix(BlockPattern pattern) {
  auto& columns = pattern.columns();
  const int n = static_cast<int>(columns.size());
  row_start_.assign(1, 0);
  for (int i = 0; i < n; ++i) {
    columns[i].push_back(i);
    std::sort(columns[i].begin(), columns[i].end());
    columns[i].erase(std::unique(columns[i].begin(), columns[i].end()), columns[i].end());
    entry_column_.insert(entry_column_.end(), columns[i].begin(), columns[i].end());
    row_start_.push_back(static_cast<int>(entry_column_.size()));
  }
  entry_slot_.resize(entry_column_.size());
  diagonal_entry_.resize(n);
  std::vector<int> next(n); // for each row, the first entry below the diagonal that has no slot yet
  int count = 0;
  for (int i = 0; i < n; ++i) {
    next[i] = row_start_[i];
    diagonal_entry_[i] = entry(i, i);
  }
  for (int i = 0; i < n; ++i)
    for (int k = diagonal_entry_[i]; k < row_start_[i + 1]; ++k) {
      entry_slot_[k] = count;
      // Rows i come in ascending order, so each row gets the slots of its entries below the diagonal in column order.
      if (entry_column_[k] > i)
        entry_slot_[next[entry_column_[k]]++] = count;
      ++count;
    }
  blocks_.assign(count, Mat3::Zero());
}

int BlockMatrix::entry(int i, int j) const {
  const auto first = entry_column_.begin() + row_start_[i], last = entry_column_.begin() + row_start_[i + 1];
  const auto it = std::lower_bound(first, last, j);
  if (i > j || it == last || *it != j)
    throw std::logic_error("block (" + std::to_string(i) + ", " + std::to_string(j) + ") is not in the pattern");
  return static_cast<int>(it - entry_column_.begin());
}

int BlockMatrix::slot(int i, int j) const {
  return entry_slot_[entry(i, j)];
}

void BlockMatrix::set_zero() {
  std::fill(blocks_.begin(), blocks_.end(), Mat3::Zero());
  rank_ones_.clear();
}

void BlockMatrix::multiply(const Vectors& x, Vectors& y) const {
  std::fill(y.begin(), y.end(), Vec3::Zero());
  for (int i = 0; i < rows(); ++i)
    for (int k = diagonal_entry_[i]; k < row_start_[i + 1]; ++k) {
      const Mat3& a = blocks_[entry_slot_[k]];
      const int j = entry_column_[k];
      y[i] += a * x[j];
      if (j > i)
        y[j] += a.transpose() * x[i];
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
