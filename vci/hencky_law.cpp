#include "vci/hencky_law.hpp"

#include <cmath>

namespace vci {

HenckyLaw::Response HenckyLaw::response(const Vec2& log_strain) const {
  const double c = 1.0 / (1.0 - poisson_ratio * poisson_ratio);
  Mat2 d;
  d << c, c * poisson_ratio, c * poisson_ratio, c;
  const Vec2 d_eps = d * log_strain;
  const double w2 = std::max(0.0, log_strain.dot(d_eps));
  const double w = std::sqrt(w2);
  Response r;
  r.strain = w;
  r.yields = w > yield_strain;
  double phi, dphi_over_w; // dphi/dw / w
  if (r.yields) {
    const double excess = w - yield_strain;
    phi = elastic_part(w) / w;
    dphi_over_w = -(1.0 - hardening) * yield_strain / (w2 * w);
    r.energy =
        stiffness * (0.5 * yield_strain * yield_strain + yield_strain * excess + 0.5 * hardening * excess * excess);
  } else {
    phi = 1.0 + stiffening * w2;
    dphi_over_w = 2.0 * stiffening;
    r.energy = stiffness * (0.5 * w2 + 0.25 * stiffening * w2 * w2);
  }
  r.stress = stiffness * phi * d_eps;
  r.tangent = stiffness * (phi * d + dphi_over_w * d_eps * d_eps.transpose());
  return r;
}

} // namespace vci
