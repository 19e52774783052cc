// Forces along the edges of device grids: axial fibres, and the code that edge laws share.
#pragma once
#include "vci/mechanics/force.hpp"

namespace vci {

/// Forces between the two vertices of edges. A subclass gives the tension of an edge as a function of its length.
class EdgeForce : public Force {
public:
  double energy(const Vectors& x) const override;
  void evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const override;
  void declare_stencils(BlockPattern& pattern) const override;
  void locate_blocks(const BlockMatrix& matrix) override;

protected:
  struct Tension {
    double energy;  ///< N mm
    double force;   ///< dE/dl, N
    double tangent; ///< d2E/dl2, N/mm
  };
  virtual Tension tension(std::size_t k, double length) const = 0;
  void add_edge(int i, int j) { edges_.push_back({i, j}); }
  /// Adds to the matrix a stiffness h (N/mm) against the relative displacement of the two vertices of edge k.
  void add_edge_stiffness(BlockMatrix& matrix, std::size_t k, const Mat3& h) const;
  double length(std::size_t k, const Vectors& x) const { return (x[edges_[k][1]] - x[edges_[k][0]]).norm(); }

  std::vector<std::array<int, 2>> edges_;

private:
  std::vector<StencilSlots<2>> slots_;
};

/// Elastic fibres. With the strain eps = ln(l / l0), a fibre has the energy k w l0 eps^2 / 2 + T0 l. Its tension is
/// therefore k w eps l0 / l + T0. Here k is the stiffness per width (N/mm), w the width (mm) and T0 the pretension.
class Fibres : public EdgeForce {
public:
  struct Fibre {
    int i, j;
    double rest_length;    ///< mm
    double stiffness;      ///< k w, N
    double pretension = 0; ///< T0, N
    bool slack = false;    ///< a film that folds: only 2 % of the stiffness where the tension would be negative
  };
  explicit Fibres(const std::vector<Fibre>& fibres);
  /// One pretension (N) per fibre.
  void set_pretension(const std::vector<double>& tension);

protected:
  Tension tension(std::size_t k, double length) const override;

private:
  std::vector<Fibre> fibres_;
};

} // namespace vci
