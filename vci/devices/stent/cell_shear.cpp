#include "vci/devices/stent/cell_shear.hpp"

namespace vci {

double CellShear::energy(const Vectors& x) const {
  double sum = 0;
  for (const Cell& cell : cells_) {
    const auto& v = cell.corner;
    const double difference = (x[v[2]] - x[v[0]]).norm() - (x[v[3]] - x[v[1]]).norm();
    sum += 0.5 * cell.coefficient * difference * difference;
  }
  return sum;
}

void CellShear::evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool) const {
  for (std::size_t k = 0; k < cells_.size(); ++k) {
    const auto& v = cells_[k].corner;
    const Vec3 one = x[v[2]] - x[v[0]], other = x[v[3]] - x[v[1]];
    const double l1 = one.norm(), l2 = other.norm(), c = cells_[k].coefficient;
    const std::array<Vec3, 4> gradient{-one / l1, other / l2, one / l1, -other / l2};
    for (int i = 0; i < 4; ++i)
      force[v[i]] -= c * (l1 - l2) * gradient[i];
    if (stiffness)
      slots_[k].add_rank_one(*stiffness, c, gradient);
  }
}

void CellShear::declare_stencils(BlockPattern& pattern) const {
  for (const Cell& cell : cells_)
    pattern.add(cell.corner);
}

void CellShear::locate_blocks(const BlockMatrix& matrix) {
  slots_.clear();
  for (const Cell& cell : cells_)
    slots_.emplace_back(matrix, cell.corner);
}

} // namespace vci
