// Shear stiffness of a stent's cells.
#pragma once
#include "vci/mechanics/force.hpp"

namespace vci {

/// E = c / 2 (d1 - d2)^2, with d1 and d2 the lengths of the diagonals of a cell of the stent's grid. The energy resists
/// shear, but stays 0 while a cell opens evenly. Without this energy, a ring under outside pressure folds in zigzag
/// along the axis at a tenth of its radial strength. The stiffness is the Gauss-Newton part c grad grad^T, with grad
/// the gradient of d1 - d2. It is exact where the diagonals are equal, and never negative.
class CellShear : public Force {
public:
  struct Cell {
    std::array<int, 4> corner; ///< diagonals run from 0 to 2 and from 1 to 3
    double coefficient;        ///< c, N/mm
  };
  explicit CellShear(std::vector<Cell> cells) : cells_(std::move(cells)) {}

  double energy(const Vectors& x) const override;
  void evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const override;
  void declare_stencils(BlockPattern& pattern) const override;
  void locate_blocks(const BlockMatrix& matrix) override;

private:
  std::vector<Cell> cells_;
  std::vector<StencilSlots<4>> slots_;
};

} // namespace vci
