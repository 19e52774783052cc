// The tissue round the vessel and the prestress of its wall, as a ring foundation at each vertex.
#pragma once
#include "vci/mechanics/vertex_force.hpp"

namespace vci {

/// Ring law at a vertex: the pressure p in the lumen, above the mean blood pressure, that holds the lumen at radius a.
///   p a = E_s / (1 + nu) (lambda - 1) b + p0 (a0 - a)
/// u is the vertex's displacement along the reference normal, so a = a0 + u. The tissue begins at radius b, behind the
/// plaque. The plaque keeps its area: b^2 = b0^2 + a^2 - a0^2. The tissue is stretched by lambda = b / b0.
///
/// The first term is the tissue: Lame's solution for a cavity in an elastic medium. The second is the prestress. In the
/// given lumen a hoop tension p0 a0 balances the mean blood pressure p0. In a wider ring this tension stays the same,
/// but balances only the pressure p0 a0 / a. For inward displacements (u < 0) the law is linear, with its slope at
/// u = 0. The healthy wall is no part of it: it must be free to move sideways (wall/wall).
struct RingLaw {
  double tissue_modulus;       ///< E_s / (1 + nu), MPa
  double tangential_stiffness; ///< MPa/mm
  double blood_pressure;       ///< p0, MPa
  double lumen_radius;         ///< a0, mm
  double tissue_radius;        ///< b0, mm

  /// Force per reference area, p a / a0 (MPa), at a displacement u (mm), and its derivative by u (MPa/mm).
  std::array<double, 2> pressure_and_slope(double u) const;
};

/// A RingLaw at each vertex. If the surface's triangles are given, the pressure follows the current
/// normals, as the force of a ring's hoop tension does. Contact forces turn with the surface too. If the pressure kept
/// its direction, contact would twist the wall about the vessel's axis once p exceeds tangential_stiffness times a. The
/// tangential stiffness also holds each vertex against sliding, since a bare membrane is singular on an irregular mesh.
class RingFoundation : public VertexForce {
public:
  struct Element {
    int vertex;
    Vec3 origin, normal; ///< reference position (mm) and unit normal out of the lumen
    double area;         ///< area of the vertex in the reference state, mm^2
    RingLaw law;
  };
  /// @param triangles the surface, with outward normals; none: the pressure keeps the direction of `normal`
  explicit RingFoundation(std::vector<Element> elements, Triangles triangles = {});

  ForceKind kind() const override { return ForceKind::foundation; }
  /// The energy for a pressure of fixed direction. A pressure that follows the normals has no energy.
  double energy(const Vectors& x) const override;
  /// The stiffness leaves out the turning of the normals.
  void evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const override;

private:
  std::vector<Element> elements_;
  Triangles triangles_;
};

} // namespace vci
