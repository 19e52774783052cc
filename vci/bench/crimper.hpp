// The head of a bench for radial strength: an iris of segments that closes round a stent.
#pragma once
#include "vci/mechanics/vertex_force.hpp"

namespace vci {

/// Pushes vertices back that are farther than R from the z axis, by the penalty energy
///   E = k / 2 max(0, sqrt(x^2 + y^2) - R)^2.
class Crimper : public VertexForce {
public:
  Crimper(std::vector<int> vertices, double stiffness_n_per_mm)
      : VertexForce(std::move(vertices)), stiffness_(stiffness_n_per_mm) {}
  /// Sets R, mm.
  void set_radius(double radius) { radius_ = radius; }
  ForceKind kind() const override { return ForceKind::foundation; }
  double energy(const Vectors& x) const override;
  void evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const override;
  /// The sum of the radial forces on all vertices, N.
  double total_force(const Vectors& x) const;

private:
  /// Distance (mm) of p beyond R; 0 within R.
  double depth(const Vec3& p) const;
  double stiffness_, radius_ = 1e3;
};

} // namespace vci
