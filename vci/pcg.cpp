#include "vci/pcg.hpp"

#include <Eigen/LU>
#include <cmath>

namespace vci {

namespace {

double dot(const Vectors& a, const Vectors& b) {
  double sum = 0; // one running sum: the same order, hence the same bits, each time
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += a[i].dot(b[i]);
  return sum;
}

void add_links(const std::vector<PointLink>& links, const Vectors& x, Vectors& y) {
  for (const PointLink& link : links) {
    Vec3 r = Vec3::Zero();
    for (int k = 0; k < 4; ++k)
      if (link.vertex[k] >= 0)
        r += link.weight[k] * x[link.vertex[k]];
    const double normal_part = (link.normal_stiffness - link.tangential_stiffness) * link.normal.dot(r);
    const Vec3 f = normal_part * link.normal + link.tangential_stiffness * r;
    for (int k = 0; k < 4; ++k)
      if (link.vertex[k] >= 0)
        y[link.vertex[k]] += link.weight[k] * f;
  }
}

std::vector<Mat3> inverse_diagonal(const BlockMatrix& matrix, const std::vector<PointLink>& links,
                                   const std::vector<char>& fixed) {
  std::vector<Mat3> diagonal(matrix.rows());
  for (int i = 0; i < matrix.rows(); ++i)
    diagonal[i] = matrix.block(matrix.diagonal_slot(i));
  for (const RankOne& term : matrix.rank_ones())
    for (std::size_t k = 0; k < term.vertex.size(); ++k)
      diagonal[term.vertex[k]] += term.stiffness * term.gradient[k] * term.gradient[k].transpose();
  for (const PointLink& link : links)
    for (int k = 0; k < 4; ++k)
      if (link.vertex[k] >= 0) {
        const double w2 = link.weight[k] * link.weight[k];
        Mat3& d = diagonal[link.vertex[k]];
        d += w2 * (link.normal_stiffness - link.tangential_stiffness) * link.normal * link.normal.transpose();
        d.diagonal().array() += w2 * link.tangential_stiffness;
      }
  for (int i = 0; i < matrix.rows(); ++i)
    diagonal[i] = fixed[i] ? Mat3::Zero() : Mat3(diagonal[i].inverse());
  return diagonal;
}

} // namespace

SolveResult solve_pcg(const BlockMatrix& matrix, const std::vector<PointLink>& links, const std::vector<char>& fixed,
                      const Vectors& right_hand_side, Vectors& x, double relative_tolerance, int maximal_iterations) {
  const std::size_t n = right_hand_side.size();
  const std::vector<Mat3> inverse = inverse_diagonal(matrix, links, fixed);
  Vectors r = right_hand_side, z(n), p(n), q(n);
  for (std::size_t i = 0; i < n; ++i)
    if (fixed[i])
      r[i].setZero();
  x.assign(n, Vec3::Zero());
  const double b_norm = std::sqrt(dot(r, r));
  if (b_norm == 0)
    return {true, 0, 0};
  for (std::size_t i = 0; i < n; ++i)
    z[i] = inverse[i] * r[i];
  p = z;
  double rz = dot(r, z);
  double residual = 1;
  for (int iteration = 1; iteration <= maximal_iterations; ++iteration) {
    matrix.multiply(p, q);
    add_links(links, p, q);
    for (std::size_t i = 0; i < n; ++i)
      if (fixed[i])
        q[i].setZero();
    const double alpha = rz / dot(p, q);
    for (std::size_t i = 0; i < n; ++i) {
      x[i] += alpha * p[i];
      r[i] -= alpha * q[i];
      z[i] = inverse[i] * r[i];
    }
    residual = std::sqrt(dot(r, r)) / b_norm;
    if (!(residual > relative_tolerance))
      return {std::isfinite(residual), iteration, residual};
    const double rz_new = dot(r, z);
    const double beta = rz_new / rz;
    rz = rz_new;
    for (std::size_t i = 0; i < n; ++i)
      p[i] = z[i] + beta * p[i];
  }
  return {false, maximal_iterations, residual};
}

} // namespace vci
