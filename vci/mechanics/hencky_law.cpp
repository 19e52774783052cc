#include "vci/mechanics/hencky_law.hpp"

#include <cmath>

namespace vci {

namespace {

// After plastic flow the elastic strain equals the yield strain up to this relative error.
constexpr double yield_rounding = 1e-9;

} // namespace

HenckyLaw::Response HenckyLaw::response_at(const Vec2& squared_stretch, bool flowed) const {
  const Vec2 log_strain = layer_strain(squared_stretch);
  const double c = 1.0 / (1.0 - poisson_ratio * poisson_ratio);
  Mat2 d;
  d << c, c * poisson_ratio, c * poisson_ratio, c;
  const Vec2 d_eps = d * log_strain;
  const double w2 = std::max(0.0, log_strain.dot(d_eps));
  const double w = std::sqrt(w2);
  Response r;
  r.strain = w;
  r.yields = w > yield_strain * (1 + (flowed ? -yield_rounding : yield_rounding));
  double phi, dphi_over_w; // the second is (dphi/dw) / w
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
  if (depth > 0) {
    const Eigen::Array2d share =
        squared_stretch.array() / (squared_stretch.array() + depth); // d layer_strain / d lumen_strain
    r.tangent = (r.tangent.array() * (share.matrix() * share.matrix().transpose()).array()).matrix();
    r.tangent.diagonal().array() += r.stress.array() * 2 * share * (1 - share);
    r.stress.array() *= share;
  }
  return r;
}

Vec2 HenckyLaw::flow(const Vec2& lumen_strain) {
  const Vec2 squared_stretch = (2 * lumen_strain).array().exp(), layer = layer_strain(squared_stretch);
  const double w = response_at(squared_stretch).strain;
  if (w <= yield_strain)
    return Vec2::Zero();
  // The elastic part of the layer's strain is the one that gives the stress at yield. The rest stays after unloading.
  const Vec2 elastic = elastic_part(w) / w * layer, permanent = layer - elastic;
  yield_strain = elastic_part(w);
  if (depth == 0)
    return permanent;
  // `depth` is relative to the lumen's radius. If the lumen has widened permanently, the layer's depth falls; if the
  // lumen has narrowed, the depth is kept. The lumen's elastic strain then follows from the layer's strain at the new
  // depth. The stress in the direction that widened more stays the same.
  const double widened = permanent.maxCoeff() > 0 ? std::exp(2 * permanent.maxCoeff()) * (1 + depth) - depth : 1;
  depth /= widened;
  return lumen_strain - Vec2(0.5 * ((2 * elastic).array().exp() * (1 + depth) - depth).log());
}

} // namespace vci
