#include "vci/solver/textbook.hpp"

#include <cmath>

namespace vci {

namespace {

double root_mean_square_velocity(const System& system) {
  double sum = 0;
  int count = 0;
  for (int i = 0; i < system.vertices(); ++i)
    if (!system.fixed[i]) {
      sum += system.velocity[i].squaredNorm();
      ++count;
    }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

/// Takes one step. Returns the number of iterations of its linear solve.
int take_step(System& system, Interactions& interactions, const IntegratorSettings& s) {
  const double h = s.fixed_step;
  Vectors elastic, foundation, force, dx;
  system.evaluate(elastic, foundation, force, true);
  std::vector<ContactPoint> points;
  const Vectors normals = area_vectors(system);
  interactions.detect(system, normals, points, h);
  add_contact_forces(points, force);
  add_tie_forces(interactions.ties, system.x, force);
  std::vector<StencilStiffness> stencils;
  for (const ContactPoint& p : points)
    stencils.push_back(p.stencil);
  for (const Tie& tie : interactions.ties)
    stencils.push_back(tie.stencil);
  system.add_damping(1 / h);
  BlockMatrix& matrix = system.matrix();
  for (int i = 0; i < system.vertices(); ++i) {
    matrix.block(matrix.diagonal_slot(i)).diagonal().array() += system.mass[i] / (h * h);
    force[i] += elastic[i] + foundation[i] + system.mass[i] / h * system.velocity[i];
  }
  PcgSettings pcg = s.pcg;
  pcg.unpreconditioned = true;
  pcg.patch_size = 0;
  const int iterations = solve_pcg(matrix, stencils, system.fixed, force, dx, pcg).iterations;
  for (int i = 0; i < system.vertices(); ++i) {
    system.x[i] += dx[i];
    system.velocity[i] = s.velocity_kept / h * dx[i];
  }
  add_slip(points, dx);
  system.commit();
  return iterations;
}

} // namespace

RelaxResult relax_textbook(System& system, Interactions& interactions, const IntegratorSettings& s, Balance* balance) {
  int steps = 0, iterations = 0;
  bool at_rest = false;
  system.velocity.assign(system.x.size(), Vec3::Zero());
  while (!at_rest && steps < s.maximal_steps) {
    iterations += take_step(system, interactions, s);
    ++steps;
    if (interactions.after_step)
      interactions.after_step(steps, {});
    const double velocity = root_mean_square_velocity(system);
    if (!std::isfinite(velocity))
      break;
    at_rest = velocity <= s.velocity_stop;
  }
  RelaxResult result = measure_balance(system, interactions, balance);
  result.converged = at_rest;
  result.steps = steps;
  result.cg_iterations = iterations;
  return result;
}

} // namespace vci
