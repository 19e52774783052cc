#include "vci/membrane.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

namespace vci {

namespace {

using Mat32 = Eigen::Matrix<double, 3, 2>;

/// Principal stretches, their material directions (columns of v) and spatial directions (columns of u).
struct Principal {
  Vec2 stretch, log_strain;
  Mat2 v;
  Mat32 u;
};

Mat32 edges(const Triangle& t, const Vectors& x) {
  Mat32 ds;
  ds.col(0) = x[t[1]] - x[t[0]];
  ds.col(1) = x[t[2]] - x[t[0]];
  return ds;
}

/// Cosine and sine of the direction of the larger eigenvalue of [a b; b d], without trigonometry.
std::array<double, 2> principal_direction(double a, double b, double d) {
  const double difference = a - d, length = std::sqrt(difference * difference + 4 * b * b);
  if (length == 0)
    return {1, 0};
  if (difference >= 0) { // the half angle from its better conditioned side
    const double c = std::sqrt(0.5 * (1 + difference / length));
    return {c, b / (length * c)};
  }
  const double s = std::copysign(std::sqrt(0.5 * (1 - difference / length)), b);
  return {b / (length * s), s};
}

Principal principal(const Mat32& f) {
  // Smallest stretch allowed: a collapsed triangle keeps a finite, strongly resisting state.
  constexpr double smallest = 1e-3;
  const double a = f.col(0).squaredNorm(), b = f.col(0).dot(f.col(1)), d = f.col(1).squaredNorm();
  const auto [c, s] = principal_direction(a, b, d);
  Principal p;
  p.v << c, -s, s, c;
  const Mat32 fv = f * p.v;
  for (int i = 0; i < 2; ++i) {
    p.stretch[i] = std::max(fv.col(i).norm(), smallest);
    p.log_strain[i] = std::log(p.stretch[i]);
    p.u.col(i) = fv.col(i) / p.stretch[i];
  }
  return p;
}

} // namespace

Membrane::Membrane(const Triangles& triangles, const Vectors& reference, std::vector<HenckyLaw> laws) {
  for (std::size_t k = 0; k < triangles.size(); ++k) {
    const Triangle& t = triangles[k];
    const Mat32 ds = edges(t, reference);
    const double area = 0.5 * ds.col(0).cross(ds.col(1)).norm();
    if (!(area > 0))
      throw std::invalid_argument("membrane triangle " + std::to_string(k) + " has no area");
    Mat2 flat; // reference edges in the triangle's plane
    const double l = ds.col(0).norm();
    flat << l, ds.col(0).dot(ds.col(1)) / l, 0, 2 * area / l;
    const Mat2 inverse = flat.inverse();
    elements_.push_back({t, {}, inverse, inverse, area, laws[k]});
  }
}

double Membrane::energy(const Vectors& x) const {
  double sum = 0;
  for (const Element& e : elements_)
    sum += e.area * e.law.response(principal(edges(e.v, x) * e.shape).log_strain).energy;
  return sum;
}

void Membrane::evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const {
  for (const Element& e : elements_) {
    const Principal p = principal(edges(e.v, x) * e.shape);
    const HenckyLaw::Response r = e.law.response(p.log_strain);
    // gradients of the shape functions in the principal frame
    Vec2 g[3];
    g[1] = p.v.transpose() * e.shape.row(0).transpose();
    g[2] = p.v.transpose() * e.shape.row(1).transpose();
    g[0] = -g[1] - g[2];
    const Vec2 sigma = r.stress.cwiseQuotient(p.stretch); // dpsi / dlambda_i
    for (int a = 0; a < 3; ++a)
      force[e.v[a]] -= e.area * (sigma[0] * g[a][0] * p.u.col(0) + sigma[1] * g[a][1] * p.u.col(1));
    if (!stiffness)
      continue;
    // Eigen-system of the Hessian with respect to F: two scalings, in-plane twist and shear, two out of plane.
    Mat2 scaling;
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j)
        scaling(i, j) = (r.tangent(i, j) - (i == j ? r.stress[i] : 0.0)) / (p.stretch[i] * p.stretch[j]);
    const double difference = p.stretch[0] - p.stretch[1];
    const double shear =
        std::abs(difference) > 1e-6 ? (sigma[0] - sigma[1]) / difference : scaling(0, 0) - scaling(0, 1);
    const double twist = (sigma[0] + sigma[1]) / (p.stretch[0] + p.stretch[1]);
    const Vec2 lift = sigma.cwiseQuotient(p.stretch);
    const Vec3 normal = p.u.col(0).cross(p.u.col(1));
    const auto [c, s] = principal_direction(scaling(0, 0), scaling(0, 1), scaling(1, 1));
    const double h = std::sqrt(0.5);
    const double s0 = c * c * scaling(0, 0) + 2 * c * s * scaling(0, 1) + s * s * scaling(1, 1);
    const double s1 = s * s * scaling(0, 0) - 2 * c * s * scaling(0, 1) + c * c * scaling(1, 1);
    const std::array<double, 6> values{s0, s1, shear, twist, lift[0], lift[1]};
    Eigen::Matrix<double, 3, 6> y[3];
    for (int a = 0; a < 3; ++a) {
      const Vec3 y0 = g[a][0] * p.u.col(0), y1 = g[a][1] * p.u.col(1);
      const Vec3 z0 = g[a][1] * p.u.col(0), z1 = g[a][0] * p.u.col(1);
      y[a].col(0) = c * y0 + s * y1;
      y[a].col(1) = c * y1 - s * y0;
      y[a].col(2) = h * (z0 + z1);
      y[a].col(3) = h * (z0 - z1);
      y[a].col(4) = g[a][0] * normal;
      y[a].col(5) = g[a][1] * normal;
    }
    Eigen::Matrix<double, 3, 6> scaled;
    for (int a = 0; a < 3; ++a) {
      for (int m = 0; m < 6; ++m)
        scaled.col(m) = e.area * (exact ? values[m] : std::max(values[m], 0.0)) * y[a].col(m);
      for (int b = 0; b <= a; ++b) {
        const Mat3 block = scaled * y[b].transpose();
        stiffness->block(e.slots[3 * a + b]) += block;
        if (b < a)
          stiffness->block(e.slots[3 * b + a]) += block.transpose();
      }
    }
  }
}

void Membrane::declare(BlockPattern& pattern) const {
  for (const Element& e : elements_)
    pattern.add(e.v);
}

void Membrane::link(const BlockMatrix& matrix) {
  for (Element& e : elements_)
    e.slots = slots_of(matrix, e.v);
}

void Membrane::commit(const Vectors& x) {
  for (Element& e : elements_) {
    const Principal p = principal(edges(e.v, x) * e.shape);
    const Vec2 flow = e.law.flow(p.log_strain);
    if (flow.isZero(0))
      continue;
    e.shape =
        e.shape * p.v * Eigen::DiagonalMatrix<double, 2>(std::exp(-flow[0]), std::exp(-flow[1])) * p.v.transpose();
  }
}

int Membrane::yielding(const Vectors& x) const {
  int count = 0;
  for (const Element& e : elements_)
    count += e.law.response(principal(edges(e.v, x) * e.shape).log_strain).yields;
  return count;
}

std::vector<double> Membrane::largest_stretch(const Vectors& x) const {
  std::vector<double> stretch;
  for (const Element& e : elements_)
    stretch.push_back(principal(edges(e.v, x) * e.inverse_edges).stretch.maxCoeff());
  return stretch;
}

} // namespace vci
