// Finite-difference checks of forces, and two small meshes for them.
#pragma once
#include "vci/mechanics/force.hpp"
#include <Eigen/Dense>
#include <gtest/gtest.h>
#include <random>

namespace force_checks {

using namespace vci;

inline Vectors perturbed(const Vectors& x, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-size, size);
  Vectors y = x;
  for (Vec3& p : y)
    for (int k = 0; k < 3; ++k)
      p[k] += shift(random);
  return y;
}

/// Two triangles that share an edge and are bent along it.
inline const Vectors sheet{{0, 0, 0}, {1, 0.1, 0}, {0.2, 0.9, 0.1}, {0.8, -0.7, 0.2}};
inline const Triangles sheet_triangles{{0, 1, 2}, {1, 0, 3}};
/// A tetrahedron whose triangles face outward.
inline const Vectors tetrahedron{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
inline const Triangles tetrahedron_triangles{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};

inline void check_gradient(const Force& force, const Vectors& x) {
  const double h = 1e-6;
  Vectors f(x.size(), Vec3::Zero());
  force.evaluate(x, f, nullptr, true);
  double size = 1e-3;
  for (const Vec3& v : f)
    size = std::max(size, v.norm());
  for (std::size_t i = 0; i < x.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      Vectors plus = x, minus = x;
      plus[i][k] += h;
      minus[i][k] -= h;
      EXPECT_NEAR(f[i][k], -(force.energy(plus) - force.energy(minus)) / (2 * h), 1e-6 * size) << i << ' ' << k;
    }
}

/// The stiffness matrix of a force as a dense matrix. @param exact as in Force::evaluate
inline Eigen::MatrixXd stiffness_of(Force& force, const Vectors& x, bool exact = true) {
  const int n = static_cast<int>(x.size());
  BlockPattern pattern(n);
  std::vector<int> all(x.size());
  for (int i = 0; i < n; ++i)
    all[i] = i;
  pattern.add(all);
  BlockMatrix matrix(std::move(pattern));
  force.locate_blocks(matrix);
  Vectors f(x.size(), Vec3::Zero()), unit = f, column = f;
  force.evaluate(x, f, &matrix, exact);
  Eigen::MatrixXd dense(3 * n, 3 * n);
  for (int j = 0; j < 3 * n; ++j) {
    unit[j / 3][j % 3] = 1;
    matrix.multiply(unit, column);
    unit[j / 3][j % 3] = 0;
    for (int i = 0; i < n; ++i)
      dense.block<3, 1>(3 * i, j) = column[i];
  }
  return dense;
}

/// Minus the derivative of a vector field with respect to the positions, by central differences.
template <class Field> Eigen::MatrixXd differences_of(const Field& field, const Vectors& x) {
  const double h = 1e-6;
  const int n = static_cast<int>(x.size());
  Eigen::MatrixXd dense(3 * n, 3 * n);
  for (int j = 0; j < 3 * n; ++j) {
    Vectors plus = x, minus = x;
    plus[j / 3][j % 3] += h;
    minus[j / 3][j % 3] -= h;
    const Vectors fp = field(plus), fm = field(minus);
    for (int i = 0; i < n; ++i)
      dense.block<3, 1>(3 * i, j) = -(fp[i] - fm[i]) / (2 * h);
  }
  return dense;
}

/// Minus the derivative of a force with respect to the positions, by central differences.
inline Eigen::MatrixXd stiffness_by_differences(const Force& force, const Vectors& x) {
  return differences_of(
      [&](const Vectors& p) {
        Vectors f(p.size(), Vec3::Zero());
        force.evaluate(p, f, nullptr, true);
        return f;
      },
      x);
}

/// The largest magnitude of the entries of `part` divided by that of `whole`.
inline double share(const Eigen::MatrixXd& part, const Eigen::MatrixXd& whole) {
  return part.cwiseAbs().maxCoeff() / whole.cwiseAbs().maxCoeff();
}

/// Expects the matrix to be minus the derivative of the force, within `tolerance` of its largest entry.
inline void check_hessian(Force& force, const Vectors& x, double tolerance = 1e-6) {
  const Eigen::MatrixXd matrix = stiffness_of(force, x), differences = stiffness_by_differences(force, x);
  const double size = std::max(1e-3, matrix.cwiseAbs().maxCoeff());
  EXPECT_LT((matrix - differences).cwiseAbs().maxCoeff(), tolerance * size);
}

} // namespace force_checks
