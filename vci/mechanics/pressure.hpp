// Pressure inside a surface, along the current normals.
#pragma once
#include "vci/geometry/surface.hpp"
#include "vci/mechanics/force.hpp"

namespace vci {

/// Force p times a third of the area vectors of the triangles round each vertex. On a closed surface it derives from
/// E = -p V. The stiffness is symmetric except at open edges, where it is left out. It is also indefinite: if a balloon
/// bends, the pressure bends it further and the axial tension straightens it, and the two almost cancel. Half of the
/// stiffness keeps the sum positive and still lets the balloon bend. With `exact` the whole stiffness is used.
class Pressure : public Force {
public:
  /// @param reference positions (mm) that `triangles` index
  Pressure(Triangles triangles, const Vectors& reference, double pressure_mpa)
      : triangles_(std::move(triangles)), edges_(interior_edges(triangles_, reference)), pressure_(pressure_mpa) {}

  ForceKind kind() const override { return ForceKind::pressure; }
  void set(double pressure_mpa) { pressure_ = pressure_mpa; }
  double energy(const Vectors& x) const override;
  void evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const override;
  void declare_stencils(BlockPattern& pattern) const override;
  void locate_blocks(const BlockMatrix& matrix) override;

private:
  Triangles triangles_;
  std::vector<InteriorEdge> edges_;
  std::vector<int> slots_; // where the matrix stores each edge's block, (e0, e1) or (e1, e0)
  double pressure_;
};

} // namespace vci
