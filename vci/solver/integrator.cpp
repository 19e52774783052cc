#include "vci/solver/integrator.hpp"
#include "vci/solver/compression_limit.hpp"
#include "vci/solver/step_relaxation.hpp"

#include <algorithm>
#include <cmath>

namespace vci {

namespace {

constexpr double smallest_step = 0.03;    // ms: length of the shortest step
constexpr int sticking_steps = 8;         // friction keeps its whole stiffness this long after a step that turned back
constexpr double quasi_static_step = 0.5; // ms: longer steps drop the velocity, and with it the inertia of the motion
// After `stalled_steps` / `careful_divisor` steps without progress, linear solves of the rest of the stage must also
// reach this relative tolerance in the preconditioner's norm.
constexpr int careful_divisor = 6;
constexpr double careful_tolerance = 0.1;
// N, over all vertices: a smaller net force counts as balance. An unloaded wall has no applied force to compare with,
// and rounding leaves about 1e-10 N at each vertex. A deployed wall carries newtons.
constexpr double negligible_force = 1e-6;

struct Forces {
  Vectors elastic, foundation, pressure, contact, total;
  std::vector<ContactPoint> points;
  double residual = 0;
};

void assemble(System& system, Interactions& interactions, Forces& f) {
  system.evaluate(f.elastic, f.foundation, f.pressure, true);
  const Vectors normals = area_vectors(system);
  f.points.clear();
  interactions.detect(system, normals, f.points);
  f.contact.assign(system.x.size(), Vec3::Zero());
  add_contact_forces(f.points, f.contact);
  add_tie_forces(interactions.ties, system.x, f.contact);
  f.total = f.elastic;
  double applied = 0, unbalanced = 0;
  for (std::size_t i = 0; i < f.total.size(); ++i) {
    const Vec3 external = f.foundation[i] + f.pressure[i] + f.contact[i];
    f.total[i] += external;
    if (!system.fixed[i]) {
      applied += external.squaredNorm();
      unbalanced += f.total[i].squaredNorm();
    }
  }
  f.residual = unbalanced <= negligible_force * negligible_force ? 0 : std::sqrt(unbalanced / applied);
}

/// The forces of the current state. They are set to 0 at fixed vertices, which need no balance.
Balance balance_of(const Forces& f, const std::vector<char>& fixed) {
  Balance balance{f.pressure, f.contact, f.foundation, f.total};
  for (Vectors* part : {&balance.pressure, &balance.contact, &balance.foundation, &balance.residual})
    for (std::size_t i = 0; i < fixed.size(); ++i)
      if (fixed[i])
        (*part)[i].setZero();
  return balance;
}

/// The displacement (mm) that one vertex in a hundred exceeds. A single loose vertex must not set the step's length.
double displacement_percentile(const Vectors& dx) {
  std::vector<double> length;
  length.reserve(dx.size());
  for (const Vec3& d : dx)
    length.push_back(d.squaredNorm());
  const auto place = length.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(length.size() - 1));
  std::nth_element(length.begin(), place, length.end());
  return std::sqrt(*place);
}

/// The part of a step's matrix that depends on the step's length h: inertia and damping, added to the diagonal (N/mm
/// for each vertex).
class Inertia {
public:
  Inertia(const System& system, const IntegratorSettings& s) : system_(system), s_(s) {}
  /// 1 + b / h, with b the stiffness damping (ms) and h in ms. Matrix and load of a step are divided by this factor.
  double damping_factor(double h) const { return 1 + s_.stiffness_damping / h; }
  /// Adds the terms for a step of h ms, and takes away those that the last call added. With `freshly_assembled`, the
  /// matrix was just assembled and holds no such terms.
  void replace_terms(double h, bool freshly_assembled, BlockMatrix& matrix) {
    if (freshly_assembled)
      added_.assign(system_.vertices(), 0.0);
    for (int i = 0; i < system_.vertices(); ++i) {
      const double part = (system_.mass[i] / (h * h) + s_.damping * system_.area[i] / h) / damping_factor(h);
      matrix.block(matrix.diagonal_slot(i)).diagonal().array() += part - added_[i];
      added_[i] = part;
    }
  }

private:
  const System& system_;
  const IntegratorSettings& s_;
  std::vector<double> added_;
};

/// Whether a step's displacements dx largely undo those of the step before: the cosine over all vertices is below -0.3.
bool turns_back(const Vectors& dx, const Vectors& last) {
  double along = 0, now = 0, before = 0;
  for (std::size_t i = 0; i < last.size(); ++i) {
    along += dx[i].dot(last[i]);
    now += dx[i].squaredNorm();
    before += last[i].squaredNorm();
  }
  return along < -0.3 * std::sqrt(now * before);
}

Imbalance largest_imbalance(const Vectors& total, const std::vector<char>& fixed) {
  Imbalance largest;
  for (std::size_t i = 0; i < total.size(); ++i)
    if (!fixed[i] && total[i].norm() > largest.force)
      largest = {total[i].norm(), static_cast<int>(i)};
  return largest;
}

void record_contact(const Forces& f, RelaxResult& result) {
  result.contacts = static_cast<int>(f.points.size());
  result.maximal_penetration = result.mean_penetration = 0;
  result.deepest = {-1, -1};
  for (const ContactPoint& p : f.points) {
    const double depth = std::max(0.0, -p.gap);
    if (depth > result.maximal_penetration) {
      result.maximal_penetration = depth;
      result.deepest = {p.stencil.vertex[0], p.stencil.vertex[1]};
    }
    result.mean_penetration += depth / static_cast<double>(f.points.size());
  }
}

} // namespace

void Interactions::remove_body(int body) {
  std::erase_if(contacts, [&](const SurfaceContact& c) { return c.inner() == body || c.outer() == body; });
  std::erase_if(self_contacts, [&](const SelfContact& c) { return c.body() == body; });
  trees->remove_body(body);
}

void Interactions::detect(const System& system, const Vectors& normals, std::vector<ContactPoint>& points,
                          double lookahead_ms) {
  const Normals all(normals);
  for (SurfaceContact& contact : contacts)
    contact.detect(system, all, points, lookahead_ms);
  for (SelfContact& contact : self_contacts)
    contact.detect(system, normals, points);
}

namespace {

/// Takes the steps of one stage towards force balance.
class Relaxation {
public:
  Relaxation(System& system, Interactions& interactions, const IntegratorSettings& settings)
      : system_(system), interactions_(interactions), s_(settings), inertia_(system, settings), pcg_(settings.pcg),
        h_(settings.initial_step) {
    system_.velocity.assign(system_.x.size(), Vec3::Zero());
  }

  RelaxResult run(Balance* balance) {
    while (!stage_ended(balance)) {
      if (settling_)
        adapt_step_to_residual();
      previous_residual_ = forces_.residual;
      gather_stencils();
      const double large_displacement = solve();
      apply_step(large_displacement);
      adapt_step_to_displacement(large_displacement);
    }
    return result_;
  }

private:
  /// Evaluates the forces at the current positions. Returns true if the stage ends here, with or without balance.
  bool stage_ended(Balance* balance) {
    assemble(system_, interactions_, forces_);
    if (forces_.residual <= s_.residual_tolerance && stiffen_deep_contacts(forces_.points, s_.maximal_penetration)) {
      assemble(system_, interactions_, forces_);
      best_residual_ = 1e300;
    }
    result_.residual = forces_.residual;
    record_contact(forces_, result_);
    if (!std::isfinite(forces_.residual))
      return true;
    if (interactions_.after_step && result_.steps > 0)
      interactions_.after_step(result_.steps, balance_of(forces_, system_.fixed));
    if (forces_.residual <= s_.residual_tolerance) {
      result_.converged = true;
      if (balance)
        *balance = balance_of(forces_, system_.fixed);
      return true;
    }
    return must_give_up();
  }

  /// Counts the steps without progress. After a sixth of `stalled_steps` of them, the linear solves become more
  /// accurate and the count begins again. Returns true if the stage must be given up: after `stalled_steps`, or at the
  /// maximal number of steps.
  bool must_give_up() {
    if (forces_.residual < 0.9 * best_residual_) {
      best_residual_ = forces_.residual;
      best_step_ = result_.steps;
    }
    const int without_progress = result_.steps - best_step_;
    if (result_.careful_from < 0 && without_progress >= std::max(1, s_.stalled_steps / careful_divisor)) {
      pcg_.preconditioned_tolerance = careful_tolerance;
      result_.careful_from = best_step_ = result_.steps;
    }
    result_.stalled = without_progress >= s_.stalled_steps;
    if (!result_.stalled && result_.steps != s_.maximal_steps)
      return false;
    result_.imbalance = largest_imbalance(forces_.total, system_.fixed);
    return true;
  }

  /// Sets the next step's length by the residual. This is done near the end of a stage, where displacements are small.
  /// Contacts that switch on and off make the residual jump, and shorter steps settle them. A balloon that slides or
  /// bends makes the residual rise slowly, and longer steps help.
  void adapt_step_to_residual() {
    h_ *= forces_.residual > 1.4 * previous_residual_ ? 0.5 : 1.8;
    h_ = std::min(std::max(h_, 10 * smallest_step), s_.maximal_step);
  }

  void gather_stencils() {
    stencils_.clear();
    for (const ContactPoint& p : forces_.points) {
      stencils_.push_back(p.stencil);
      if (sticking_ > 0) // sliding contacts may stick again
        stencils_.back().slip_softening.setZero();
    }
    for (const Tie& tie : interactions_.ties)
      stencils_.push_back(tie.stencil);
  }

  /// Largest displacement allowed in a step, mm.
  double displacement_limit() const { return 1.5 * s_.displacement_per_step; }

  /// Solves for the displacements, and again with a shorter step while they exceed the limit. A step that is too long
  /// is not taken, because its plastic strain would be permanent. Returns the displacement (mm) that one vertex in a
  /// hundred exceeds.
  double solve() {
    for (bool freshly_assembled = true;;) {
      inertia_.replace_terms(h_, freshly_assembled, system_.matrix());
      load_.resize(forces_.total.size());
      for (int i = 0; i < system_.vertices(); ++i)
        load_[i] = (forces_.total[i] + system_.mass[i] / h_ * system_.velocity[i]) / inertia_.damping_factor(h_);
      result_.cg_iterations +=
          solve_pcg(system_.matrix(), stencils_, system_.fixed, load_, dx_, pcg_, &preconditioner_).iterations;
      ++result_.steps;
      freshly_assembled = result_.steps < s_.maximal_steps && system_.stop_reversed_flow(dx_);
      if (freshly_assembled) { // the matrix was made for a plastic flow that now reverses
        assemble(system_, interactions_, forces_);
        gather_stencils();
        continue;
      }
      const double large_displacement = displacement_percentile(dx_);
      if (large_displacement <= displacement_limit() || h_ <= smallest_step || result_.steps == s_.maximal_steps)
        return large_displacement;
      h_ = std::max(smallest_step, h_ * std::clamp(s_.displacement_per_step / large_displacement, 0.1, 0.5));
    }
  }

  /// Moves the vertices and commits slip and plastic strain.
  void apply_step(double large_displacement) {
    const bool inertial = h_ <= quasi_static_step;
    if (!inertial)
      relaxation_.damp(dx_, last_dx_, large_displacement);
    // Only a vertex that exceeds the limit is held back, since the step is good for the others.
    for (Vec3& d : dx_)
      if (const double length = d.norm(); length > displacement_limit())
        d *= displacement_limit() / length;
    limit_compression(system_, dx_);
    for (int i = 0; i < system_.vertices(); ++i) {
      system_.x[i] += dx_[i];
      system_.velocity[i] = inertial ? Vec3(dx_[i] / h_) : Vec3(Vec3::Zero());
    }
    add_slip(forces_.points, dx_);
    system_.commit();
    sticking_ = turns_back(dx_, last_dx_) ? sticking_steps : sticking_ - 1;
    last_dx_ = dx_;
  }

  void adapt_step_to_displacement(double large_displacement) {
    const double step_scale = large_displacement > 0 ? s_.displacement_per_step / large_displacement : 2.0;
    settling_ = forces_.residual < 0.1 && step_scale > 4.0;
    if (!settling_)
      h_ = std::min(std::max(h_ * std::clamp(step_scale, 0.4, 2.0), smallest_step), s_.maximal_step);
  }

  System& system_;
  Interactions& interactions_;
  const IntegratorSettings& s_;
  RelaxResult result_;
  Forces forces_;
  Vectors dx_, last_dx_, load_;
  std::vector<StencilStiffness> stencils_;
  PreconditionerCache preconditioner_;
  Inertia inertia_;
  PcgSettings pcg_;
  StepRelaxation relaxation_; ///< shortens the steps of oscillating vertices
  double h_;                  ///< length of the step, ms
  double previous_residual_ = 0, best_residual_ = 1e300;
  int best_step_ = 0;
  int sticking_ = 0;      ///< number of further steps in which sliding contacts keep their whole friction stiffness
  bool settling_ = false; ///< the residual, no longer the displacements, sets the step's length
};

} // namespace

RelaxResult relax(System& system, Interactions& interactions, const IntegratorSettings& settings, Balance* balance) {
  return Relaxation(system, interactions, settings).run(balance);
}

RelaxResult measure_balance(System& system, Interactions& interactions, Balance* balance) {
  Forces forces;
  assemble(system, interactions, forces);
  RelaxResult result;
  result.residual = forces.residual;
  record_contact(forces, result);
  if (balance)
    *balance = balance_of(forces, system.fixed);
  return result;
}

} // namespace vci
