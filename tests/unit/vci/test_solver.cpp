// The block matrix and conjugate gradients against a direct solve.
#include "vci/linalg/pcg.hpp"
#include <Eigen/Dense>
#include <gtest/gtest.h>
#include <random>

namespace {

using namespace vci;

TEST(Pcg, MatchesADirectSolveWithLinksAndFixedVertices) {
  const int n = 12;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  BlockPattern pattern(n);
  for (int i = 0; i + 1 < n; ++i)
    pattern.add(std::array<int, 2>{i, i + 1});
  BlockMatrix matrix(std::move(pattern));
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  for (int i = 0; i + 1 < n; ++i) {
    Eigen::Matrix<double, 6, 6> g, a;
    for (int r = 0; r < 6; ++r)
      for (int c = 0; c < 6; ++c)
        g(r, c) = number(random);
    a = g * g.transpose() + Eigen::Matrix<double, 6, 6>::Identity();
    for (int p = 0; p < 2; ++p)
      for (int q = p; q < 2; ++q)
        matrix.block(matrix.slot(i + p, i + q)) += a.block<3, 3>(3 * p, 3 * q);
    dense.block<6, 6>(3 * i, 3 * i) += a;
  }
  const StencilStiffness link{{0, 5, 7, 9}, {-1, 0.2, 0.3, 0.5}, Vec3(1, 2, 2) / 3, 7.0, 0.5};
  Eigen::MatrixXd w = Eigen::MatrixXd::Zero(3, 3 * n);
  for (int k = 0; k < 4; ++k)
    w.block<3, 3>(0, 3 * link.vertex[k]) = link.weight[k] * Mat3::Identity();
  const Mat3 k3 = 0.5 * Mat3::Identity() + 6.5 * link.normal * link.normal.transpose();
  dense += w.transpose() * k3 * w;
  std::vector<char> fixed(n, 0);
  fixed[3] = 1;
  Vectors b(n), x;
  Eigen::VectorXd rhs(3 * n);
  for (int i = 0; i < n; ++i) {
    b[i] = Vec3(number(random), number(random), number(random));
    rhs.segment<3>(3 * i) = b[i];
  }
  dense.middleRows(9, 3).setZero();
  dense.middleCols(9, 3).setZero();
  dense.block<3, 3>(9, 9).setIdentity();
  rhs.segment<3>(9).setZero();
  const Eigen::VectorXd exact = dense.ldlt().solve(rhs);
  const SolveResult result = solve_pcg(matrix, {link}, fixed, b, x, {1e-12, 200});
  EXPECT_TRUE(result.converged);
  for (int i = 0; i < n; ++i)
    EXPECT_LT((x[i] - exact.segment<3>(3 * i)).norm(), 1e-9);
  EXPECT_EQ(x[3].norm(), 0);
}

TEST(Pcg, SaysSoWhenItRunsOutOfIterations) {
  BlockPattern pattern(2);
  pattern.add(std::array<int, 2>{0, 1});
  BlockMatrix matrix(std::move(pattern));
  matrix.block(matrix.diagonal_slot(0)) = Vec3(1, 10, 100).asDiagonal();
  matrix.block(matrix.diagonal_slot(1)) = Vec3(2, 20, 300).asDiagonal();
  matrix.block(matrix.slot(0, 1)) = 0.9 * Mat3::Identity();
  Vectors x;
  const SolveResult result = solve_pcg(matrix, {}, {0, 0}, {Vec3(1, 2, 3), Vec3(4, 5, 6)}, x, {1e-14, 1});
  EXPECT_FALSE(result.converged);
  EXPECT_EQ(result.iterations, 1);
  EXPECT_GT(result.residual, 1e-14);
}

/// A chain of springs, held at its first vertex and pulled at its last. Its displacement is one long wave, which the
/// block Jacobi preconditioner passes on slowly.
struct Chain {
  static constexpr int n = 120;
  BlockMatrix matrix;
  std::vector<char> fixed;
  Vectors pull;
  Chain() : fixed(n, 0), pull(n, Vec3::Zero()) {
    BlockPattern pattern(n);
    for (int i = 0; i + 1 < n; ++i)
      pattern.add(std::array<int, 2>{i, i + 1});
    matrix = BlockMatrix(std::move(pattern));
    for (int i = 0; i + 1 < n; ++i)
      for (int p = 0; p < 2; ++p)
        for (int q = p; q < 2; ++q)
          matrix.block(matrix.slot(i + p, i + q)) += (p == q ? 1 : -1) * Mat3::Identity();
    fixed[0] = 1;
    pull[n - 1] = Vec3(1, 2, -1);
  }
};

TEST(Pcg, PatchesSpareIterationsAndBothPrecisionsAgree) {
  const Chain chain;
  Vectors plain, patched, single;
  const SolveResult one = solve_pcg(chain.matrix, {}, chain.fixed, chain.pull, plain, {1e-5, 500});
  const SolveResult two = solve_pcg(chain.matrix, {}, chain.fixed, chain.pull, patched, {1e-5, 500, 10});
  const SolveResult third = solve_pcg(chain.matrix, {}, chain.fixed, chain.pull, single, {1e-5, 500, 10, true});
  EXPECT_TRUE(one.converged && two.converged && third.converged);
  EXPECT_LT(2 * two.iterations, one.iterations);
  for (int i = 0; i < Chain::n; ++i)
    for (const Vectors* x : {&plain, &patched, &single})
      EXPECT_LT(((*x)[i] - i * Vec3(1, 2, -1)).norm(), 1e-3 * Chain::n) << i;
}

TEST(Pcg, StopsWhereTheMatrixIsNotPositive) {
  Chain chain;
  chain.matrix.block(chain.matrix.diagonal_slot(60)) -= 5 * Mat3::Identity();
  Vectors x;
  const SolveResult result = solve_pcg(chain.matrix, {}, chain.fixed, chain.pull, x, {1e-12, 500});
  EXPECT_FALSE(result.converged);
  EXPECT_LT(result.iterations, 500);
  EXPECT_TRUE(x[Chain::n - 1].allFinite());
}

TEST(BlockMatrix, RefusesABlockOutsideThePattern) {
  BlockMatrix matrix{BlockPattern(3)};
  EXPECT_THROW(matrix.slot(0, 2), std::logic_error);
}

} // namespace
