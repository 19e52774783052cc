#include "vci/linalg/pcg.hpp"
#include "vci/linalg/coarse_space.hpp"

#include <Eigen/LU>
#include <cmath>

namespace vci {

namespace {

/// Inverse diagonal blocks, 0 at fixed vertices.
std::vector<Mat3> inverse_diagonal(const BlockMatrix& matrix, const std::vector<StencilStiffness>& stencils,
                                   const std::vector<char>& fixed) {
  std::vector<Mat3> diagonal(matrix.rows());
  for (int i = 0; i < matrix.rows(); ++i)
    diagonal[i] = matrix.block(matrix.diagonal_slot(i));
  for (const RankOne& term : matrix.rank_ones())
    for (std::size_t k = 0; k < term.vertex.size(); ++k)
      diagonal[term.vertex[k]] += term.stiffness * term.gradient[k] * term.gradient[k].transpose();
  for (const StencilStiffness& stencil : stencils) {
    const Mat3 stiffness = stencil.stiffness();
    for (int k = 0; k < 4; ++k)
      if (stencil.vertex[k] >= 0)
        diagonal[stencil.vertex[k]] += stencil.weight[k] * stencil.weight[k] * stiffness;
  }
  for (int i = 0; i < matrix.rows(); ++i)
    diagonal[i] = fixed[i] ? Mat3::Zero() : Mat3(diagonal[i].inverse());
  return diagonal;
}

template <class Real> class Solver {
public:
  using Operator = LinearOperator<Real>;
  using Field = typename Operator::Field;
  using PaddedVector = typename Operator::PaddedVector;

  Solver(const BlockMatrix& matrix, const std::vector<StencilStiffness>& stencils, const std::vector<char>& fixed,
         const PcgSettings& settings, std::shared_ptr<const CoarseSpace> coarse)
      : settings_(settings), operator_(matrix, stencils, fixed), coarse_(std::move(coarse)) {
    for (const Mat3& m : inverse_diagonal(matrix, stencils, fixed))
      inverse_diagonal_.push_back(Operator::padded(settings.unpreconditioned ? Mat3(Mat3::Identity()) : m));
  }

  SolveResult solve(const Field& b, Field& x) const {
    const std::size_t n = b.size();
    Field r = b, z(n), p, q(n);
    const double b_norm = std::sqrt(dot(r, r));
    x.assign(n, PaddedVector::Zero());
    if (b_norm == 0)
      return {true, 0, 0};
    precondition(r, z);
    p = z;
    double rz = dot(r, z), residual = 1;
    const double rz_target = settings_.preconditioned_tolerance * settings_.preconditioned_tolerance * rz;
    for (int iteration = 1; iteration <= settings_.maximal_iterations; ++iteration) {
      operator_.multiply(p, q);
      const double curvature = dot(p, q);
      if (curvature <= 0) { // the matrix is not positive along p, but the solution so far still reduces the energy
        if (iteration == 1)
          x = p;
        return {false, iteration, residual};
      }
      const Real alpha = static_cast<Real>(rz / curvature);
      for (std::size_t i = 0; i < n; ++i) {
        x[i] += alpha * p[i];
        r[i] -= alpha * q[i];
      }
      residual = std::sqrt(dot(r, r)) / b_norm;
      precondition(r, z);
      const double rz_new = dot(r, z);
      if (!(residual > settings_.tolerance) && !(rz_new > rz_target))
        return {std::isfinite(residual), iteration, residual};
      const Real beta = static_cast<Real>(rz_new / rz);
      rz = rz_new;
      for (std::size_t i = 0; i < n; ++i)
        p[i] = z[i] + beta * p[i];
    }
    return {false, settings_.maximal_iterations, residual};
  }

private:
  /// Scalar product by four running sums. Their fixed order makes the result the same to the last bit in each run.
  static double dot(const Field& a, const Field& b) {
    PaddedVector sum = PaddedVector::Zero();
    double total = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      sum += a[i] * b[i];
      if (i % 256 == 255) { // single precision would lose the small terms of a long sum
        total += sum.template cast<double>().sum();
        sum.setZero();
      }
    }
    return total + sum.template cast<double>().sum();
  }
  void precondition(const Field& r, Field& z) const {
    for (std::size_t i = 0; i < r.size(); ++i)
      z[i] = Operator::product(inverse_diagonal_[i], r[i]);
    if (coarse_)
      coarse_->apply(r, z);
  }

  PcgSettings settings_;
  Operator operator_;
  std::vector<typename Operator::Block> inverse_diagonal_;
  std::shared_ptr<const CoarseSpace> coarse_;
};

/// The preconditioner's second level; null for none. A second level made for an earlier matrix is used again for a few
/// solves, unless record_iterations() has dropped it.
std::shared_ptr<const CoarseSpace> cached_coarse_space(const BlockMatrix& matrix,
                                                       const std::vector<StencilStiffness>& stencils,
                                                       const std::vector<char>& fixed, int patch_size,
                                                       PreconditionerCache& cache) {
  constexpr int maximal_age = 5; // solves for which a second level is used
  if (patch_size == 0)
    return {};
  if (!cache.coarse || cache.age >= maximal_age || cache.coarse->vertices() != matrix.rows()) {
    const auto built = std::make_shared<CoarseSpace>(matrix, stencils, fixed, patch_size);
    cache = {built->usable() ? built : nullptr, 0, 0};
  }
  return cache.coarse;
}

void record_iterations(int iterations, PreconditionerCache& cache) {
  // The second level is dropped after a solve with more iterations than this multiple of its first solve's, plus 2.
  constexpr double allowed_growth = 1.3;
  if (cache.age == 0)
    cache.first_iterations = iterations;
  ++cache.age;
  if (iterations > allowed_growth * cache.first_iterations + 2)
    cache.coarse.reset();
}

template <class Real>
SolveResult solve_in_precision(const BlockMatrix& matrix, const std::vector<StencilStiffness>& stencils,
                               const std::vector<char>& fixed, const Vectors& right_hand_side, Vectors& x,
                               const PcgSettings& settings, PreconditionerCache& cache) {
  using Operator = LinearOperator<Real>;
  const Solver<Real> solver(matrix, stencils, fixed, settings,
                            cached_coarse_space(matrix, stencils, fixed, settings.patch_size, cache));
  typename Operator::Field b, solution;
  b.reserve(right_hand_side.size());
  for (std::size_t i = 0; i < right_hand_side.size(); ++i)
    b.push_back(fixed[i] ? Operator::padded(Vec3(Vec3::Zero())) : Operator::padded(right_hand_side[i]));
  const SolveResult result = solver.solve(b, solution);
  record_iterations(result.iterations, cache);
  x.resize(b.size());
  for (std::size_t i = 0; i < b.size(); ++i)
    x[i] = solution[i].template head<3>().template cast<double>().matrix();
  return result;
}

} // namespace

SolveResult solve_pcg(const BlockMatrix& matrix, const std::vector<StencilStiffness>& stencils,
                      const std::vector<char>& fixed, const Vectors& right_hand_side, Vectors& x,
                      const PcgSettings& settings, PreconditionerCache* cache) {
  PreconditionerCache local;
  PreconditionerCache& kept = cache ? *cache : local;
  return settings.single_precision
             ? solve_in_precision<float>(matrix, stencils, fixed, right_hand_side, x, settings, kept)
             : solve_in_precision<double>(matrix, stencils, fixed, right_hand_side, x, settings, kept);
}

} // namespace vci
