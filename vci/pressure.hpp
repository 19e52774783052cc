// Pressure inside a surface, following its current normals.
#pragma once
#include "vci/force.hpp"

namespace vci {

/// Force p times a third of the area vectors of the triangles round each vertex; of a closed surface it derives from
/// E = -p V. Its stiffness is left out: it is indefinite and would spoil the conjugate gradients.
class Pressure : public Force {
public:
  Pressure(Triangles triangles, double pressure_mpa) : triangles_(std::move(triangles)), pressure_(pressure_mpa) {}

  ForceKind kind() const override { return ForceKind::pressure; }
  void set(double pressure_mpa) { pressure_ = pressure_mpa; }
  double energy(const Vectors& x) const override;
  void evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const override;
  void declare(BlockPattern&) const override {}
  void link(const BlockMatrix&) override {}

private:
  Triangles triangles_;
  double pressure_;
};

} // namespace vci
