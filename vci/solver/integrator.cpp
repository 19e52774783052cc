#include "vci/solver/integrator.hpp"
#include "vci/solver/step_relaxation.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace vci {

namespace {

constexpr double smallest_step = 0.03; // ms
constexpr int sticking_steps = 8;      // with all of friction's stiffness, after a step that turned back
constexpr double quasi_static = 0.5;   // ms: longer steps drop the velocity
// Steps that do not come nearer to balance for this share of `stalled_steps` are damped from then on: oscillating
// vertices are held back, and linear solves must reach this tolerance in the preconditioner's norm, too.
constexpr int careful_share = 3;
constexpr double careful_tolerance = 0.1;
constexpr double rounding = 1e-9; // N: a wall back in its first state has no applied force to compare with

struct Forces {
  Vectors elastic, foundation, pressure, contact, total;
  std::vector<ContactPoint> points;
  double residual;
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
  double applied = 0, left = 0;
  for (std::size_t i = 0; i < f.total.size(); ++i) {
    const Vec3 outside = f.foundation[i] + f.pressure[i] + f.contact[i];
    f.total[i] += outside;
    if (!system.fixed[i]) {
      applied += outside.squaredNorm();
      left += f.total[i].squaredNorm();
    }
  }
  f.residual = left <= rounding * rounding ? 0 : std::sqrt(left / applied);
}

/// The forces of the state reached; what a fixed vertex's support carries is no part of the balance.
Balance balance_of(const Forces& f, const std::vector<char>& fixed) {
  Balance balance{f.pressure, f.contact, f.foundation, f.total};
  for (Vectors* part : {&balance.pressure, &balance.contact, &balance.foundation, &balance.residual})
    for (std::size_t i = 0; i < fixed.size(); ++i)
      if (fixed[i])
        (*part)[i].setZero();
  return balance;
}

/// The displacement that one vertex in a hundred exceeds: a single loose vertex does not rule the step.
double large_displacement(const Vectors& dx) {
  std::vector<double> length;
  length.reserve(dx.size());
  for (const Vec3& d : dx)
    length.push_back(d.squaredNorm());
  const auto place = length.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(length.size() - 1));
  std::nth_element(length.begin(), place, length.end());
  return std::sqrt(*place);
}

/// The part of a step's matrix that changes with its length: what it adds to the diagonal, N/mm per vertex.
class Inertia {
public:
  Inertia(const System& system, const IntegratorSettings& s) : system_(system), s_(s) {}
  /// 1 + b / h: the whole step is divided by it.
  double factor(double h) const { return 1 + s_.stiffness_damping / h; }
  /// Puts the part of a step of h ms in place of that of the step before, or on a matrix made anew.
  void put(double h, bool anew, BlockMatrix& matrix) {
    if (anew)
      added_.assign(system_.vertices(), 0.0);
    for (int i = 0; i < system_.vertices(); ++i) {
      const double part = (system_.mass[i] / (h * h) + s_.damping * system_.area[i] / h) / factor(h);
      matrix.block(matrix.diagonal_slot(i)).diagonal().array() += part - added_[i];
      added_[i] = part;
    }
  }

private:
  const System& system_;
  const IntegratorSettings& s_;
  std::vector<double> added_;
};

/// Whether a step takes back much of the one before.
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

void read_contact(const Forces& f, RelaxResult& result) {
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

void Interactions::forget(int body) {
  std::erase_if(contacts, [&](const SurfaceContact& c) { return c.inner() == body || c.outer() == body; });
  std::erase_if(self_contacts, [&](const SelfContact& c) { return c.body() == body; });
  trees->forget(body);
}

void Interactions::detect(const System& system, const Vectors& normals, std::vector<ContactPoint>& points,
                          double ahead) {
  const Normals all(normals);
  for (SurfaceContact& contact : contacts)
    contact.detect(system, all, points, ahead);
  for (SelfContact& contact : self_contacts)
    contact.detect(system, normals, points);
}

RelaxResult relax(System& system, Interactions& interactions, const IntegratorSettings& s, Balance* balance) {
  RelaxResult result;
  Forces f;
  Vectors dx, last_dx, load;
  std::vector<StencilStiffness> stencils;
  PcgMemory memory;
  Inertia inertia(system, s);
  PcgSettings pcg = s.pcg;
  std::optional<StepRelaxation> careful;
  double h = s.initial_step, previous_residual = 0, best_residual = 1e300;
  int best_step = 0, held = 0;
  bool settling = false;
  system.velocity.assign(system.x.size(), Vec3::Zero());
  while (true) {
    assemble(system, interactions, f);
    result.residual = f.residual;
    read_contact(f, result);
    if (!std::isfinite(f.residual))
      return result;
    if (interactions.after_step && result.steps > 0)
      interactions.after_step(result.steps, balance_of(f, system.fixed));
    if (f.residual <= s.residual_tolerance) {
      result.converged = true;
      if (balance)
        *balance = balance_of(f, system.fixed);
      return result;
    }
    if (f.residual < 0.9 * best_residual) {
      best_residual = f.residual;
      best_step = result.steps;
    }
    const int without_progress = result.steps - best_step;
    if (!careful && without_progress >= std::max(1, s.stalled_steps / careful_share)) {
      careful.emplace();
      pcg.preconditioned_tolerance = careful_tolerance;
      result.careful_from = best_step = result.steps;
    }
    result.stalled = without_progress >= s.stalled_steps;
    if (result.stalled || result.steps == s.maximal_steps) {
      result.imbalance = largest_imbalance(f.total, system.fixed);
      return result;
    }
    // Near the end displacements are small, and the residual steers the step. Contacts that switch on and off make it
    // jump; shorter steps settle them. A slow rise is a balloon that slides or bends, and needs no shorter steps.
    if (settling) {
      h *= f.residual > 1.4 * previous_residual ? 0.5 : 1.8;
      h = std::clamp(h, 10 * smallest_step, s.maximal_step);
    }
    previous_residual = f.residual;

    stencils.clear();
    for (const ContactPoint& p : f.points) {
      stencils.push_back(p.stencil);
      if (held > 0) // a sliding contact may stick again
        stencils.back().sliding.setZero();
    }
    for (const Tie& tie : interactions.ties)
      stencils.push_back(tie.stencil);
    const double limit = 1.5 * s.displacement_per_step;
    double typical = 0;
    for (bool anew = true;; anew = false) {
      inertia.put(h, anew, system.matrix());
      load.resize(f.total.size());
      for (int i = 0; i < system.vertices(); ++i)
        load[i] = (f.total[i] + system.mass[i] / h * system.velocity[i]) / inertia.factor(h);
      result.cg_iterations += solve_pcg(system.matrix(), stencils, system.fixed, load, dx, pcg, &memory).iterations;
      ++result.steps;
      typical = large_displacement(dx);
      if (typical <= limit || h <= smallest_step || result.steps == s.maximal_steps)
        break; // a step that is too long is repeated: its plastic strain would stay
      h = std::max(smallest_step, h * std::clamp(s.displacement_per_step / typical, 0.1, 0.5));
    }
    const bool inertial = h <= quasi_static;
    if (careful && !inertial)
      careful->damp(dx, last_dx, typical);
    // A vertex that overshoots is clipped by itself: the step is good for the others.
    for (int i = 0; i < system.vertices(); ++i) {
      const double length = dx[i].norm();
      if (length > limit)
        dx[i] *= limit / length;
      system.x[i] += dx[i];
      system.velocity[i] = inertial ? Vec3(dx[i] / h) : Vec3(Vec3::Zero());
    }
    add_slip(f.points, dx);
    system.commit();
    held = turns_back(dx, last_dx) ? sticking_steps : held - 1;
    last_dx = dx;
    const double step_scale = typical > 0 ? s.displacement_per_step / typical : 2.0;
    settling = f.residual < 0.1 && step_scale > 4.0;
    if (!settling)
      h = std::clamp(h * std::clamp(step_scale, 0.4, 2.0), smallest_step, s.maximal_step);
  }
}

} // namespace vci
