// The septum: the tissue between two branches, behind the carina.
#pragma once
#include "vci/mechanics/force.hpp"

namespace vci {

/// Tetrahedra of a compressible neo-Hookean solid that join the walls of two branches. Each one has a vertex of one
/// wall and a triangle of the other wall behind it. The ring foundation knows only the tissue round its own branch.
/// Without the septum, a balloon pushes the wall of its branch through the wall of the other one.
///
/// Energy per reference volume, with the deformation gradient F, J = det F, and Lame's constants lambda and mu (Bonet
/// and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, section 6.4.3):
///   mu / 2 (F : F - 3) - mu ln J + lambda / 2 (ln J)^2
/// Below J = 0.2 the logarithm goes on as its Taylor polynomial of second order. So an element that a solver step
/// turned inside out is pushed back.
class Septum : public Force {
public:
  struct Element {
    std::array<int, 4> vertex; ///< the vertex, then the triangle behind it
    Mat3 inverse_edges;        ///< inverse of the matrix whose columns are the reference edges from vertex 0, 1/mm
    double volume;             ///< volume of the tissue that the element represents, mm^3
    double modulus;            ///< Young's modulus, MPa
  };
  explicit Septum(std::vector<Element> elements, double poisson_ratio);

  double energy(const Vectors& x) const override;
  void evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const override;
  void declare_stencils(BlockPattern& pattern) const override;
  void locate_blocks(const BlockMatrix& matrix) override;

private:
  std::vector<Element> elements_;
  double shear_share_, lambda_share_; ///< Lame's mu and lambda over Young's modulus
  std::vector<StencilSlots<4>> slots_;
};

/// What lies between two lumens: a wall on each side, and softer tissue where the walls do not touch.
struct SeptumTissue {
  double wall_thickness; ///< intima and media of one branch, mm
  double wall_modulus;   ///< MPa
  double tissue_modulus; ///< MPa; 0: only walls that touch each other are joined
  /// Young's modulus of a septum (MPa): both walls and the tissue between them, one behind the other.
  /// @param thickness distance of the two lumens, mm
  double modulus(double thickness) const;
};

/// The elements of all septa of a wall. The triangle behind a vertex is the closest triangle of another branch, within
/// five wall thicknesses. Each side of a septum gets half of its volume.
/// @param triangles, points the wall (mm), with normals out of the lumen
/// @param branch branch of each triangle; empty: there is one branch, so there is no septum
std::vector<Septum::Element> septum_elements(const Triangles& triangles, const Vectors& points,
                                             const std::vector<int>& branch, const SeptumTissue& tissue);

} // namespace vci
