// Bending: a quadratic law of the dihedral angle at each interior edge.
#pragma once
#include "vci/geometry/surface.hpp"
#include "vci/mechanics/force.hpp"

namespace vci {

/// E = 1/2 c (theta - theta0)^2 (discrete shells, Grinspun et al. 2003). The stiffness is the Gauss-Newton part
/// c grad grad^T, which is exact at the rest angle and never negative.
class Hinges : public Force {
public:
  /// @param coefficients c per edge, N mm; @param reference gives the rest angles.
  /// @param yield_angle rad: beyond it the rest angle follows (plastic fold); infinity for none.
  Hinges(const std::vector<EdgePair>& edges, const Vectors& reference, const std::vector<double>& coefficients,
         double yield_angle);

  double energy(const Vectors& x) const override;
  void evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const override;
  void declare(BlockPattern& pattern) const override;
  void link(const BlockMatrix& matrix) override;
  void commit(const Vectors& x) override;

private:
  struct Element {
    std::array<int, 4> v; // edge start, edge end, left and right opposite vertex
    StencilSlots<4> slots;
    double coefficient, rest_angle;
  };
  std::vector<Element> elements_;
  double yield_angle_;
};

/// c = 3 D l^2 / (A1 + A2) of a shell with bending rigidity D (N mm); l, A: reference length and areas.
std::vector<double> shell_coefficients(const std::vector<EdgePair>& edges, const Vectors& reference, double rigidity);

/// Signed dihedral angle (rad; 0 flat, positive when the surface is convex towards its normals) and its gradient.
struct Dihedral {
  double angle;
  std::array<Vec3, 4> gradient;
};
Dihedral dihedral(const Vec3& e0, const Vec3& e1, const Vec3& left, const Vec3& right);

} // namespace vci
