// The media and the tissue outside the lumen surface, as a ring foundation at each vertex.
#pragma once
#include "vci/mechanics/vertex_force.hpp"

namespace vci {

/// Ring law at a vertex: the pressure p that holds the lumen at radius a.
///   p a = E_m t_m (lambda - 1) (1 + beta (lambda - 1)^2) + E_s / (1 + nu) (lambda - 1) b + p0 (a0 - a)
/// u is the vertex's displacement along the reference normal, so a = a0 + u. The plaque between the lumen and the media
/// (radius b) keeps its area: b^2 = b0^2 + a^2 - a0^2. The media is stretched by lambda = b / b0.
///
/// The three parts are the media, the tissue round it, and the prestress. In the given lumen a hoop tension p0 a0
/// balances the mean blood pressure p0. The tension stays the same in a wider ring, but holds only the pressure
/// p0 a0 / a there. Inwards (u < 0) the law is linear, with its slope at 0.
struct RingLaw {
  double media_stiffness;      ///< E_m t_m, N/mm
  double stiffening;           ///< beta
  double tissue_modulus;       ///< E_s / (1 + nu), MPa
  double tangential_stiffness; ///< MPa/mm
  double blood_pressure;       ///< p0, MPa
  double lumen_radius;         ///< a0, mm
  double media_radius;         ///< b0, mm

  /// Pressure per reference area, p a / a0 (MPa), and its derivative by u (MPa/mm).
  std::array<double, 2> pressure(double u) const;
};

/// The pressure follows the surface's normal where its triangles are given, as the hoop tension of a ring does. Contact
/// forces turn with the surface. Against a pressure of fixed direction they would twist the wall about the vessel's
/// axis once p > tangential_stiffness a. Each vertex is also held against sliding by tangential_stiffness, since a bare
/// membrane is singular on an irregular mesh.
class RingFoundation : public VertexForce {
public:
  struct Element {
    int vertex;
    Vec3 origin, normal; ///< reference position (mm) and unit normal out of the lumen
    double area;         ///< mm^2
    RingLaw law;
  };
  /// @param triangles of the surface, with outward normals; none: the pressure keeps the direction of `normal`
  explicit RingFoundation(std::vector<Element> elements, Triangles triangles = {});

  ForceKind kind() const override { return ForceKind::foundation; }
  /// The energy for a pressure of fixed direction; a pressure that follows the surface has none.
  double energy(const Vectors& x) const override;
  /// The stiffness leaves out how the normals turn.
  void evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const override;

private:
  std::vector<Element> elements_;
  Triangles triangles_;
};

} // namespace vci
