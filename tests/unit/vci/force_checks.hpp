// Finite-difference checks of forces, and small shapes to do them on.
#pragma once
#include "vci/force.hpp"
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

/// Two bent triangles over an edge.
inline const Vectors sheet{{0, 0, 0}, {1, 0.1, 0}, {0.2, 0.9, 0.1}, {0.8, -0.7, 0.2}};
inline const Triangles sheet_triangles{{0, 1, 2}, {1, 0, 3}};
/// A tetrahedron, outward.
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

inline void check_hessian(Force& force, const Vectors& x, double tolerance = 1e-6) {
  const double h = 1e-6;
  BlockPattern pattern(static_cast<int>(x.size()));
  std::vector<int> all(x.size());
  for (std::size_t i = 0; i < x.size(); ++i)
    all[i] = static_cast<int>(i);
  pattern.add(all);
  BlockMatrix matrix(std::move(pattern));
  force.link(matrix);
  Vectors f(x.size(), Vec3::Zero());
  force.evaluate(x, f, &matrix, true);
  double size = 1e-3;
  for (int i : all)
    size = std::max(size, matrix.block(matrix.diagonal_slot(i)).norm());
  for (std::size_t j = 0; j < x.size(); ++j)
    for (int k = 0; k < 3; ++k) {
      Vectors plus = x, minus = x;
      plus[j][k] += h;
      minus[j][k] -= h;
      Vectors fp(x.size(), Vec3::Zero()), fm = fp;
      force.evaluate(plus, fp, nullptr, true);
      force.evaluate(minus, fm, nullptr, true);
      for (std::size_t i = 0; i < x.size(); ++i) {
        const Vec3 column = matrix.at(static_cast<int>(i), static_cast<int>(j)).col(k);
        EXPECT_LT((column + (fp[i] - fm[i]) / (2 * h)).norm(), tolerance * size) << i << ' ' << j << ' ' << k;
      }
    }
}

} // namespace force_checks
