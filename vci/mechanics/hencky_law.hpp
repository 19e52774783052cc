// Plane-stress law in logarithmic (Hencky) strains of the principal stretches, with stiffening or yield.
#pragma once
#include "vci/linalg/types.hpp"
#include <limits>

namespace vci {

/// Equivalent elastic strain w: w^2 = eps . D eps with D = 1/(1 - nu^2) [1 nu; nu 1], eps the principal strains.
/// Kirchhoff stress resultants t_i = E phi(w) (D eps)_i, E a modulus times thickness (N/mm), where
///   phi = 1 + beta w^2                        healthy wall: stiffens
///   phi = (w_y + H (w - w_y)) / w, w > w_y    plaque, film: yields with linear hardening
/// which derive from the energy per reference area E psi(w), psi' = phi w.
///
/// A layer at radius R, outside a lumen of radius a, stretches less than the lumen. Incompressible tissue between lumen
/// and layer gives lambda_R^2 = (lambda^2 + q) / (1 + q), with the depth q = (R/a)^2 - 1. This holds for a ring, and is
/// used for both principal stretches. The formulas above are in the layer's strain, Response is in the lumen's strain.
struct HenckyLaw {
  /// E: modulus times thickness times R/a, N/mm. The factor R/a is the layer's reference area over the lumen's, because
  /// energies and stresses refer to the lumen.
  double stiffness;
  double poisson_ratio = 0.45;
  double stiffening = 0; ///< beta; only without yield
  double yield_strain = std::numeric_limits<double>::infinity();
  double hardening = 0; ///< H, 0 to 1
  double depth = 0;     ///< q; 0 at the lumen itself

  struct Response {
    double energy; ///< N/mm
    Vec2 stress;   ///< d energy / d eps_i, eps the lumen's strain, N/mm
    Mat2 tangent;  ///< d stress_i / d eps_j, N/mm
    double strain; ///< w, by the layer's strain
    bool yields;
  };
  /// @param squared_stretch squared principal stretches of the lumen
  /// @param flowed whether the last step made plastic strain permanent. The elastic strain then equals the yield strain
  /// up to rounding. This flag, not rounding, decides the tangent there: plastic if true, else elastic.
  Response response_at(const Vec2& squared_stretch, bool flowed = false) const;
  bool yields_at(const Vec2& squared_stretch) const {
    return strain_squared(layer_strain(squared_stretch)) > yield_strain * yield_strain;
  }
  /// The part of w that is elastic once the layer yields. Times E it gives the equivalent stress.
  double elastic_part(double w) const { return yield_strain + hardening * (w - yield_strain); }
  /// Lets the layer yield and harden at a logarithmic strain of the lumen. Returns the permanent part of this strain.
  /// The caller must subtract it from later strains.
  Vec2 flow(const Vec2& log_strain);

private:
  /// w^2 at a layer's strain.
  double strain_squared(const Vec2& e) const {
    return (e.squaredNorm() + 2 * poisson_ratio * e[0] * e[1]) / (1.0 - poisson_ratio * poisson_ratio);
  }
  /// The layer's logarithmic strain.
  /// @param squared_stretch squared principal stretches of the lumen
  Vec2 layer_strain(const Vec2& squared_stretch) const {
    return 0.5 * ((squared_stretch.array() + depth) / (1 + depth)).log();
  }
};

} // namespace vci
