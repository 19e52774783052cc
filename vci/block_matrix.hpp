// Symmetric sparse matrix of 3x3 blocks with a pattern that is fixed between changes of the mesh.
#pragma once
#include "vci/types.hpp"

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

/// stiffness g g^T over some vertices: a term that couples them all, cheaper kept apart than stored as blocks.
struct RankOne {
  std::vector<int> vertex;
  Vectors gradient; ///< g, one vector per vertex
  double stiffness;
};

/// Rows in compressed form; each row holds its diagonal block, columns ascending.
class BlockMatrix {
public:
  BlockMatrix() = default;
  explicit BlockMatrix(BlockPattern pattern);

  int rows() const { return static_cast<int>(start_.size()) - 1; }
  /// Position of block (i, j); throws std::logic_error where the pattern has none.
  int slot(int i, int j) const;
  int entries() const { return static_cast<int>(column_.size()); }
  int row_start(int i) const { return start_[i]; }
  int column(int slot) const { return column_[slot]; }
  int diagonal_slot(int i) const { return diagonal_[i]; }
  Mat3& block(int slot) { return values_[slot]; }
  const Mat3& block(int slot) const { return values_[slot]; }
  void set_zero();
  void add(RankOne term) { rank_ones_.push_back(std::move(term)); }
  const std::vector<RankOne>& rank_ones() const { return rank_ones_; }
  /// y = A x.
  void multiply(const Vectors& x, Vectors& y) const;

private:
  std::vector<int> start_, column_, diagonal_;
  std::vector<Mat3> values_;
  std::vector<RankOne> rank_ones_;
};

} // namespace vci
