// Constant-strain membrane triangles with Hencky law and plastic flow.
#pragma once
#include "vci/mechanics/force.hpp"
#include "vci/mechanics/hencky_law.hpp"
#include "vci/mechanics/layer.hpp"

namespace vci {

/// The deformation gradient of a triangle is F = D_s B P (3x2). D_s holds the current edges, B the inverse of the
/// reference edges, and P the inverse of the plastic part. The energy is the reference area times the HenckyLaw's
/// energy at the principal stretches of F.
class Membrane : public Force, public Layer {
public:
  /// @param reference positions (mm) of the unstressed state
  /// @param laws law of each triangle
  /// Throws std::invalid_argument for a triangle without area.
  Membrane(const Triangles& triangles, const Vectors& reference, std::vector<HenckyLaw> laws);

  double energy(const Vectors& x) const override;
  void evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const override;
  void declare_stencils(BlockPattern& pattern) const override;
  void locate_blocks(const BlockMatrix& matrix) override;
  void commit(const Vectors& x) override;

  /// Number of triangles that yield at positions x.
  int count_yielding(const Vectors& x) const;
  std::vector<double> largest_stretch(const Vectors& x) const override;

private:
  struct Element {
    Triangle v;
    StencilSlots<3> slots;
    Mat2 inverse_edges;         // B
    Mat2 elastic_inverse_edges; // B P
    double area;                // area of the reference triangle, mm^2
    HenckyLaw law;
    bool flowed = false; // whether the last step made plastic strain permanent
  };
  std::vector<Element> elements_;
};

} // namespace vci
