// A smooth axis: a quintic smoothing spline through noisy points, parametrised by arc length.
#pragma once
#include "core/types.hpp"
#include <unsupported/Eigen/Splines>

namespace anatomy {

/// Minimises sum w |x(t_i) - x_i|^2 + lambda int |x'''|^2 dt over quintic B-splines (Eilers & Marx 1996). A penalty of
/// the second derivative would straighten a bend; a penalty of the third does not. lambda is the largest value for
/// which the residual equals the noise of the points (Morozov's discrepancy principle). The noise is estimated from
/// their sixth differences.
class Axis {
public:
  Axis() = default;
  /// points: in order, about evenly spaced, at least 2; the first and last are met exactly.
  explicit Axis(const std::vector<Vec3>& points);

  double length() const { return s_.back(); }
  Vec3 at(double s) const;
  Vec3 tangent(double s) const;
  double curvature(double s) const; ///< 1/mm
  double torsion(double s) const;   ///< 1/mm; 0 if the curvature is below 0.01 /mm, since it has no meaning there
  double noise() const { return noise_; }

private:
  using Spline = Eigen::Spline<double, 3, 5>;
  void fit(const std::vector<double>& t, const std::vector<Vec3>& x, double rms_target);
  void tabulate();
  double parameter(double s) const;

  Spline spline_;
  double noise_ = 0, t_end_ = 0;
  std::vector<double> s_, t_; ///< arc length against parameter
};

/// Standard deviation of the points' noise per coordinate, from sixth differences, whose variance is 924 sigma^2 for
/// white noise. Every fourth point is used, or nearer ones if there are few. With fourth differences the bends of a
/// tortuous vessel would count as noise of some 0.008 mm, and would be smoothed.
double noise_of(const std::vector<Vec3>& points);

} // namespace anatomy
