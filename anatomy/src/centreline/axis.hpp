// A smooth axis: a quintic smoothing spline through noisy points, parametrised by arc length.
#pragma once
#include "core/types.hpp"
#include <unsupported/Eigen/Splines>

namespace anatomy {

/// The spline minimises sum w |x(t_i) - x_i|^2 + lambda int |x'''|^2 dt over quintic B-splines (Eilers & Marx 1996). A
/// penalty of the second derivative would straighten a bend; a penalty of the third does not. lambda is the largest
/// value, up to 1e5 mm^5, whose residual does not exceed the noise of the points (Morozov's discrepancy principle). The
/// noise is estimated from the points' sixth differences.
class Axis {
public:
  Axis() = default;
  /// Fits the spline to two or more `points` (mm), in order and about evenly spaced. The first and the last have so
  /// large a weight that the spline meets them.
  explicit Axis(const std::vector<Vec3>& points);

  double length() const { return s_.back(); } ///< mm
  Vec3 at(double s) const;                    ///< point at arc length s; both in mm
  Vec3 tangent(double s) const;               ///< unit tangent at arc length s (mm)
  double curvature(double s) const;           ///< 1/mm, at arc length s (mm)
  double torsion(double s) const; ///< 1/mm; 0 if the curvature is below 0.01 /mm, since torsion has no meaning there
  double noise() const { return noise_; } ///< noise_of(points), mm

private:
  using Spline = Eigen::Spline<double, 3, 5>;
  void fit(const std::vector<double>& t, const std::vector<Vec3>& x, double rms_target);
  void tabulate();
  double parameter(double s) const;

  Spline spline_;
  double noise_ = 0, t_end_ = 0;
  std::vector<double> s_, t_; ///< table of arc length (mm) and the spline's parameter
};

/// Standard deviation (mm) of the points' noise in each coordinate. It follows from sixth differences, whose variance
/// is 924 sigma^2 for white noise. A difference is taken over every fourth point, or over nearer points if there are
/// few. With fourth differences the bends of a tortuous vessel would count as noise of some 0.008 mm, and would be
/// smoothed.
double noise_of(const std::vector<Vec3>& points);

} // namespace anatomy
