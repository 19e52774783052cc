// Symmetric sparse matrix of 3x3 blocks with a pattern that is fixed between changes of the mesh.
#pragma once
#include "vci/linalg/types.hpp"

namespace vci {

/// Collects which pairs of vertices interact.
class BlockPattern {
public:
  explicit BlockPattern(int vertex_count) : columns_(vertex_count) {}
  /// Declares that all vertices of a stencil interact with one another.
  template <class Stencil> void add(const Stencil& stencil) {
    for (int i : stencil)
      for (int j : stencil)
        columns_[i].push_back(j);
  }
  std::vector<std::vector<int>>& columns() { return columns_; }

private:
  std::vector<std::vector<int>> columns_;
};

/// A term k g g^T of the matrix, which couples all vertices of a list. Stored as blocks it would cost more.
struct RankOne {
  std::vector<int> vertex;
  Vectors gradient; ///< g, one vector for each of these vertices
  double stiffness; ///< k
};

/// Rows in compressed form, columns ascending; each row holds its diagonal block. Only blocks of the upper half have
/// values: block (j, i) is block (i, j) transposed.
class BlockMatrix {
public:
  BlockMatrix() = default;
  explicit BlockMatrix(BlockPattern pattern);

  int rows() const { return static_cast<int>(row_start_.size()) - 1; }
  /// Where the values of block (i, j), i <= j, are stored. Throws std::logic_error if the pattern lacks the block.
  int slot(int i, int j) const;
  int diagonal_slot(int i) const { return entry_slot_[diagonal_entry_[i]]; }
  Mat3& block(int slot) { return blocks_[slot]; }
  const Mat3& block(int slot) const { return blocks_[slot]; }
  /// Block (i, j) of either half.
  Mat3 at(int i, int j) const { return i <= j ? blocks_[slot(i, j)] : Mat3(blocks_[slot(j, i)].transpose()); }

  // The pattern of both halves. Its entries are numbered row by row.
  int entries() const { return static_cast<int>(entry_column_.size()); }
  int row_start(int i) const { return row_start_[i]; }
  int diagonal_entry(int i) const { return diagonal_entry_[i]; }
  int column(int entry) const { return entry_column_[entry]; }
  /// Where an entry's values are stored. Below the diagonal these are the values of the transposed block.
  int entry_slot(int entry) const { return entry_slot_[entry]; }
  void set_zero();
  void add(RankOne term) { rank_ones_.push_back(std::move(term)); }
  const std::vector<RankOne>& rank_ones() const { return rank_ones_; }
  /// y = A x.
  void multiply(const Vectors& x, Vectors& y) const;

private:
  int entry(int i, int j) const;
  std::vector<int> row_start_, entry_column_, diagonal_entry_, entry_slot_;
  std::vector<Mat3> blocks_;
  std::vector<RankOne> rank_ones_;
};

} // namespace vci
