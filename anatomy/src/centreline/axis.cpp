#include "centreline/axis.hpp"
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

namespace anatomy {
namespace {

constexpr int degree = 5;
constexpr double knot_spacing = 0.75; // mm between the spline's knots: several knots for a coronary bend of 3 mm radius
constexpr double pin_weight = 1e6;    // weight of the first and the last point in the fit; the other points have 1
// noise_of() takes differences over every fourth point. Neighbours 0.25 mm apart share Voronoi spheres, so their noise
// shows only from 1 mm apart.
constexpr std::size_t noise_stride = 4;
constexpr double table_step = 0.02; // mm between entries of the table of arc length

using Sparse = Eigen::SparseMatrix<double>;
using Knots = Eigen::Array<double, 1, Eigen::Dynamic>;
using AnySpline = Eigen::Spline<double, 3, degree>;

Knots clamped_knots(double t_end) {
  const int intervals = std::max(1, static_cast<int>(std::lround(t_end / knot_spacing)));
  Knots knots(intervals + 1 + 2 * degree);
  for (int i = 0; i < knots.size(); ++i)
    knots(i) = t_end * std::clamp(i - degree, 0, intervals) / intervals;
  return knots;
}

// A matrix with a row for each t and a column for each basis function: its value (order 0) or third derivative (order
// 3).
Sparse basis(const Knots& knots, const std::vector<double>& t, int order) {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t i = 0; i < t.size(); ++i) {
    const auto span = AnySpline::Span(t[i], degree, knots);
    const auto values = AnySpline::BasisFunctionDerivatives(t[i], order, degree, knots);
    for (int k = 0; k <= degree; ++k)
      entries.emplace_back(static_cast<int>(i), static_cast<int>(span) - degree + k, values(order, k));
  }
  Sparse b(static_cast<int>(t.size()), knots.size() - degree - 1);
  b.setFromTriplets(entries.begin(), entries.end());
  return b;
}

// The matrix of int B'''_i B'''_j dt, by three Gauss points in each interval between knots. They are exact, since the
// integrand is a polynomial of degree 4.
Sparse roughness(const Knots& knots) {
  std::vector<double> t;
  std::vector<double> weight;
  for (int i = degree; i + degree + 1 < knots.size(); ++i) {
    const double half = 0.5 * (knots(i + 1) - knots(i)), middle = 0.5 * (knots(i + 1) + knots(i));
    for (const auto& [x, w] : {std::pair{-std::sqrt(0.6), 5.0 / 9}, {0.0, 8.0 / 9}, {std::sqrt(0.6), 5.0 / 9}}) {
      t.push_back(middle + half * x);
      weight.push_back(half * w);
    }
  }
  const Sparse b = basis(knots, t, 3);
  const Eigen::Map<Eigen::VectorXd> w(weight.data(), static_cast<Eigen::Index>(weight.size()));
  return b.transpose() * w.asDiagonal() * b;
}

} // namespace

double noise_of(const std::vector<Vec3>& x) {
  constexpr std::array<double, 7> difference{1, -6, 15, -20, 15, -6, 1}; // sum of squares: 924
  const std::size_t k = std::clamp<std::size_t>(x.size() / 9, 1, noise_stride), reach = 6 * k;
  if (x.size() < reach + 3)
    return 0;
  double sum = 0;
  for (std::size_t i = 0; i + reach < x.size(); ++i) {
    Vec3 d = Vec3::Zero();
    for (std::size_t j = 0; j < difference.size(); ++j)
      d += difference[j] * x[i + j * k];
    sum += d.squaredNorm();
  }
  return std::sqrt(sum / (924.0 * 3 * static_cast<double>(x.size() - reach)));
}

Axis::Axis(const std::vector<Vec3>& points) {
  // Chord length along noisy points is too long, so the parameter is computed again along the first fit.
  std::vector<double> t{0};
  for (std::size_t i = 1; i < points.size(); ++i)
    t.push_back(t.back() + (points[i] - points[i - 1]).norm());
  noise_ = noise_of(points);
  fit(t, points, noise_);
  std::size_t at = 0;
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    double nearest = 1e300;
    std::size_t best = at;
    for (std::size_t j = at; j < s_.size() && s_[j] < s_[at] + 3; ++j) {
      const double d = (Vec3(spline_(t_[j])) - points[i]).squaredNorm();
      if (d < nearest) {
        nearest = d;
        best = j;
      }
    }
    at = best;
    // The parameter belongs to the foot of the perpendicular from the point on the spline. The nearest entry of the
    // table would add noise along the axis.
    const auto here = spline_.derivatives(t_[at], 1);
    t[i] = s_[at] + (points[i] - Vec3(here.col(0))).dot(Vec3(here.col(1)).normalized());
  }
  t.back() = s_.back();
  fit(t, points, noise_);
}

void Axis::fit(const std::vector<double>& t, const std::vector<Vec3>& x, double rms_target) {
  t_end_ = t.back();
  const Knots knots = clamped_knots(t_end_);
  const Sparse b = basis(knots, t, 0), p = roughness(knots);
  const auto n = static_cast<Eigen::Index>(x.size());
  Eigen::VectorXd w = Eigen::VectorXd::Ones(n);
  w(0) = w(n - 1) = pin_weight;
  Eigen::MatrixXd data(n, 3);
  for (Eigen::Index i = 0; i < n; ++i)
    data.row(i) = x[static_cast<std::size_t>(i)].transpose();
  const Sparse btwb = b.transpose() * w.asDiagonal() * b;
  const Eigen::MatrixXd rhs = b.transpose() * w.asDiagonal() * data;
  Eigen::SimplicialLDLT<Sparse> solver;
  Eigen::MatrixXd coefficients;
  const auto residual = [&](double log_lambda) {
    const Sparse a = btwb + std::pow(10.0, log_lambda) * p;
    solver.compute(a);
    coefficients = solver.solve(rhs);
    return std::sqrt((b * coefficients - data).squaredNorm() / static_cast<double>(3 * n));
  };
  // The lower bound of lambda, 1e-3 mm^5, keeps the matrix regular at a gap between points, and does not move a bend of
  // radius 3 mm.
  double low = -3, high = 5;
  if (residual(low) < rms_target) {
    if (residual(high) > rms_target)
      for (int i = 0; i < 30; ++i) {
        const double middle = 0.5 * (low + high);
        (residual(middle) < rms_target ? low : high) = middle;
      }
    else
      low = high;
  }
  residual(low);
  spline_ = Spline(knots, coefficients.transpose());
  tabulate();
}

void Axis::tabulate() {
  const int n = std::max(2, static_cast<int>(std::lround(t_end_ / table_step)));
  s_.assign(1, 0);
  t_.assign(1, 0);
  Vec3 before = spline_(0.0);
  for (int i = 1; i <= n; ++i) {
    const double t = t_end_ * i / n;
    const Vec3 here = spline_(t);
    s_.push_back(s_.back() + (here - before).norm());
    t_.push_back(t);
    before = here;
  }
}

double Axis::parameter(double s) const {
  const double inside = std::clamp(s, 0.0, length());
  const auto above = std::lower_bound(s_.begin() + 1, s_.end() - 1, inside);
  const auto i = static_cast<std::size_t>(above - s_.begin());
  return t_[i - 1] + (t_[i] - t_[i - 1]) * (inside - s_[i - 1]) / (s_[i] - s_[i - 1]);
}

Vec3 Axis::at(double s) const {
  return spline_(parameter(s));
}

Vec3 Axis::tangent(double s) const {
  return Vec3(spline_.derivatives(parameter(s), 1).col(1)).normalized();
}

double Axis::curvature(double s) const {
  const auto d = spline_.derivatives(parameter(s), 2);
  const Vec3 x1 = d.col(1), x2 = d.col(2);
  return x1.cross(x2).norm() / std::pow(x1.norm(), 3);
}

double Axis::torsion(double s) const {
  const auto d = spline_.derivatives(parameter(s), 3);
  const Vec3 x1 = d.col(1), x2 = d.col(2), x3 = d.col(3);
  const Vec3 binormal = x1.cross(x2);
  if (binormal.norm() < 0.01 * std::pow(x1.norm(), 3))
    return 0;
  return binormal.dot(x3) / binormal.squaredNorm();
}

} // namespace anatomy
