// Plane-stress law in logarithmic (Hencky) strains of the principal stretches, with stiffening or yield.
#pragma once
#include "vci/types.hpp"
#include <limits>

namespace vci {

/// Equivalent elastic strain w: w^2 = eps . D eps with D = 1/(1 - nu^2) [1 nu; nu 1].
/// Kirchhoff stress resultants t_i = E phi(w) (D eps)_i, E a modulus times thickness (N/mm), where
///   phi = 1 + beta w^2                        healthy wall: stiffens
///   phi = (w_y + H (w - w_y)) / w, w > w_y    plaque, film: yields with linear hardening
/// which derive from the energy per reference area E psi(w), psi' = phi w.
struct HenckyLaw {
  double stiffness; ///< modulus times thickness, N/mm
  double poisson_ratio = 0.45;
  double stiffening = 0; ///< beta; only without yield
  double yield_strain = std::numeric_limits<double>::infinity();
  double hardening = 0; ///< H, 0 to 1

  struct Response {
    double energy; ///< N/mm
    Vec2 stress;   ///< t_i, N/mm
    Mat2 tangent;  ///< d t_i / d eps_j, N/mm
    double strain; ///< w
    bool yields;
  };
  Response response(const Vec2& log_strain) const;
  /// Elastic part of w that stays after yield: E times it is the stress reached.
  double elastic_part(double w) const { return yield_strain + hardening * (w - yield_strain); }
};

} // namespace vci
