// Constant-strain membrane triangles with Hencky law and plastic flow.
#pragma once
#include "vci/mechanics/force.hpp"
#include "vci/mechanics/hencky_law.hpp"
#include "vci/mechanics/layer.hpp"

namespace vci {

/// F = D_s B P (3x2): current edges D_s, inverse reference edges B, inverse plastic part P. Energy A0 E psi(ln lambda).
class Membrane : public Force, public Layer {
public:
  /// @param law per triangle; @param reference positions of the unstressed state. Throws std::invalid_argument for a
  /// triangle without area.
  Membrane(const Triangles& triangles, const Vectors& reference, std::vector<HenckyLaw> laws);

  double energy(const Vectors& x) const override;
  void evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const override;
  void declare(BlockPattern& pattern) const override;
  void link(const BlockMatrix& matrix) override;
  void commit(const Vectors& x) override;

  /// Triangles that yield at x.
  int yielding(const Vectors& x) const;
  std::vector<double> largest_stretch(const Vectors& x) const override;

private:
  struct Element {
    Triangle v;
    StencilSlots<3> slots;
    Mat2 inverse_edges; // B
    Mat2 shape;         // B P
    double area;
    HenckyLaw law;
    bool flows = false; // the last step left a set
  };
  std::vector<Element> elements_;
};

} // namespace vci
