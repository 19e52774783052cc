// Hoop laws of a stent's rings.
#pragma once
#include "vci/mechanics/force.hpp"

namespace vci {

/// Elastic-plastic hoop law of closed rings. All edges of a ring have the same tension T(L), with L the length of the
/// whole ring, since a ring of struts opens as a whole. With a law for each edge, the first edge that yields would take
/// all of the opening (necking).
///   T = k e,  e = L / L0 - 1;  beyond e_y  T = sign(e) k (e_y + H (|e| - e_y)), and L0 follows (isotropic hardening).
/// The Hessian T' g g^T + T dg/dx, g = dL/dx, couples all vertices of a ring. Its first part is added to the matrix as
/// a RankOne.
class RingHoops : public Force {
public:
  struct Ring {
    std::vector<int> vertices;          ///< in order; the last joins the first
    double stiffness;                   ///< k, N
    double yield_strain, hardening = 0; ///< e_y, H (0 to 1)
    double rest_length = 0;             ///< L0, mm
    int flow_sign = 0; ///< sign of e if the last step made plastic strain permanent (its tangent is then H k), else 0
  };
  explicit RingHoops(std::vector<Ring> rings) : rings_(std::move(rings)) {}

  double energy(const Vectors& x) const override;
  void evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const override;
  void declare_stencils(BlockPattern& pattern) const override;
  void locate_blocks(const BlockMatrix& matrix) override;
  void commit(const Vectors& x) override;
  bool stop_reversed_flow(const Vectors& x, const Vectors& dx) override;
  /// Number of rings that yield at positions x.
  int count_yielding(const Vectors& x) const;

private:
  std::vector<Ring> rings_;
  std::vector<StencilSlots<2>> slots_; // edge by edge
};

/// Keeps neighbouring edges of a ring equally long, since struts are rigid pieces of one pattern. The energy is
/// E = c / 2 ln(l_i / l_i+1)^2. The logarithm keeps every edge from collapsing, and an even opening has no energy. The
/// stiffness is the Gauss-Newton part of the Hessian.
class RingEvenness : public Force {
public:
  struct Ring {
    std::vector<int> vertices;
    double coefficient; ///< c, N mm
  };
  explicit RingEvenness(const std::vector<Ring>& rings);

  double energy(const Vectors& x) const override;
  void evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const override;
  void declare_stencils(BlockPattern& pattern) const override;
  void locate_blocks(const BlockMatrix& matrix) override;

private:
  struct Element {
    std::array<int, 3> v; // the vertices of two neighbouring edges
    double coefficient;
    StencilSlots<3> slots{};
  };
  std::vector<Element> elements_;
};

} // namespace vci
