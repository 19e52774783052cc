// Bending: a quadratic law of the dihedral angle at each interior edge.
#pragma once
#include "vci/geometry/surface.hpp"
#include "vci/mechanics/force.hpp"

namespace vci {

/// E = 1/2 c (theta - theta0)^2, with the dihedral angle theta and the rest angle theta0 (discrete shells, Grinspun et
/// al. 2003). The stiffness is the Gauss-Newton part c grad grad^T, grad the gradient of theta. It is exact at the rest
/// angle and never negative.
class Hinges : public Force {
public:
  /// @param coefficients c of each edge, N mm
  /// @param reference positions (mm) at which all edges have their rest angles
  /// @param yield_angles rad: an edge bent by more keeps a plastic fold; pi or more: no plastic folds
  Hinges(const std::vector<InteriorEdge>& edges, const Vectors& reference, const std::vector<double>& coefficients,
         const std::vector<double>& yield_angles);
  /// As above, with the same yield angle at each edge.
  Hinges(const std::vector<InteriorEdge>& edges, const Vectors& reference, const std::vector<double>& coefficients,
         double yield_angle)
      : Hinges(edges, reference, coefficients, std::vector<double>(edges.size(), yield_angle)) {}

  double energy(const Vectors& x) const override;
  void evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const override;
  void declare_stencils(BlockPattern& pattern) const override;
  void locate_blocks(const BlockMatrix& matrix) override;
  void commit(const Vectors& x) override;

private:
  struct Element {
    std::array<int, 4> v; // edge start, edge end, left and right opposite vertex
    StencilSlots<4> slots;
    double coefficient, yield_angle, rest_angle;
  };
  std::vector<Element> elements_;
};

/// Coefficient c (N mm) of each edge for a shell of bending rigidity D (N mm): c = 3 D l^2 / (A1 + A2). Here l is the
/// edge's reference length, and A1 and A2 are the areas of the triangles beside it.
std::vector<double> shell_coefficients(const std::vector<InteriorEdge>& edges, const Vectors& reference,
                                       double rigidity);

/// Signed dihedral angle (rad; 0 flat, positive when the surface is convex towards its normals) and its gradient.
struct Dihedral {
  double angle;
  std::array<Vec3, 4> gradient; ///< with respect to the positions of e0, e1, left and right, rad/mm
};
/// @param e0, e1 ends of the edge
/// @param left, right the opposite vertices of the two triangles beside the edge
Dihedral dihedral(const Vec3& e0, const Vec3& e1, const Vec3& left, const Vec3& right);

} // namespace vci
