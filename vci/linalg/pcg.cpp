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
  using Four = typename Operator::Four;

  Solver(const BlockMatrix& matrix, const std::vector<StencilStiffness>& stencils, const std::vector<char>& fixed,
         const PcgSettings& settings, std::shared_ptr<const CoarseSpace> coarse)
      : settings_(settings), operator_(matrix, stencils, fixed), coarse_(std::move(coarse)) {
    for (const Mat3& m : inverse_diagonal(matrix, stencils, fixed))
      inverse_.push_back(Operator::padded(settings.plain ? Mat3(Mat3::Identity()) : m));
  }

  SolveResult solve(const Field& b, Field& x) const {
    const std::size_t n = b.size();
    Field r = b, z(n), p, q(n);
    const double b_norm = std::sqrt(dot(r, r));
    x.assign(n, Four::Zero());
    if (b_norm == 0)
      return {true, 0, 0};
    precondition(r, z);
    p = z;
    double rz = dot(r, z), residual = 1;
    const double rz_wanted = settings_.preconditioned_tolerance * settings_.preconditioned_tolerance * rz;
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
      if (!(residual > settings_.tolerance) && !(rz_new > rz_wanted))
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
    Four sum = Four::Zero();
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
      z[i] = Operator::product(inverse_[i], r[i]);
    if (coarse_)
      coarse_->apply(r, z);
  }

  PcgSettings settings_;
  Operator operator_;
  std::vector<typename Operator::Block> inverse_;
  std::shared_ptr<const CoarseSpace> coarse_;
};

/// The preconditioner's second level; null for none. The one made for an earlier matrix is used again for a few solves,
/// unless the number of iterations has grown much.
std::shared_ptr<const CoarseSpace> coarse_space(const BlockMatrix& matrix,
                                                const std::vector<StencilStiffness>& stencils,
                                                const std::vector<char>& fixed, int patch_size, PcgMemory& memory) {
  constexpr int oldest = 5; // solves for which a second level is used
  if (patch_size == 0)
    return {};
  if (!memory.coarse || memory.age >= oldest || memory.coarse->vertices() != matrix.rows()) {
    const auto made = std::make_shared<CoarseSpace>(matrix, stencils, fixed, patch_size);
    memory = {made->usable() ? made : nullptr, 0, 0};
  }
  return memory.coarse;
}

void remember(int iterations, PcgMemory& memory) {
  constexpr double worse = 1.3; // a second level is dropped above this multiple of its first solve's iterations, plus 2
  if (memory.age == 0)
    memory.first_iterations = iterations;
  ++memory.age;
  if (iterations > worse * memory.first_iterations + 2)
    memory.coarse.reset();
}

template <class Real>
SolveResult solve_in(const BlockMatrix& matrix, const std::vector<StencilStiffness>& stencils,
                     const std::vector<char>& fixed, const Vectors& right_hand_side, Vectors& x,
                     const PcgSettings& settings, PcgMemory& memory) {
  using Operator = LinearOperator<Real>;
  const Solver<Real> solver(matrix, stencils, fixed, settings,
                            coarse_space(matrix, stencils, fixed, settings.patch_size, memory));
  typename Operator::Field b, solution;
  b.reserve(right_hand_side.size());
  for (std::size_t i = 0; i < right_hand_side.size(); ++i)
    b.push_back(fixed[i] ? Operator::padded(Vec3(Vec3::Zero())) : Operator::padded(right_hand_side[i]));
  const SolveResult result = solver.solve(b, solution);
  remember(result.iterations, memory);
  x.resize(b.size());
  for (std::size_t i = 0; i < b.size(); ++i)
    x[i] = solution[i].template head<3>().template cast<double>().matrix();
  return result;
}

} // namespace

SolveResult solve_pcg(const BlockMatrix& matrix, const std::vector<StencilStiffness>& stencils,
                      const std::vector<char>& fixed, const Vectors& right_hand_side, Vectors& x,
                      const PcgSettings& settings, PcgMemory* memory) {
  PcgMemory own;
  PcgMemory& used = memory ? *memory : own;
  return settings.single_precision ? solve_in<float>(matrix, stencils, fixed, right_hand_side, x, settings, used)
                                   : solve_in<double>(matrix, stencils, fixed, right_hand_side, x, settings, used);
}

} // namespace vci
