// Pseudo-transient backward Euler towards force balance.
#pragma once
#include "vci/contact/self_contact.hpp"

#include <functional>

namespace vci {

struct IntegratorSettings {
  double residual_tolerance = 3e-3;
  double maximal_penetration = 0.05;   ///< mm: in balance, contacts deeper than this are stiffened, and steps go on
  double displacement_per_step = 0.12; ///< mm, steers the step
  double initial_step = 0.3;           ///< ms
  double maximal_step = 200.0;         ///< ms
  int maximal_steps = 1500;
  int stalled_steps = 150; ///< a stage gives up when its residual has not fallen by a tenth for so many steps
  PcgSettings pcg{0.2, 300, 24, true};
  double damping = 2.5;           ///< MPa ms/mm, per unit area
  double stiffness_damping = 0.0; ///< ms
  bool textbook = false;          ///< the scheme of textbook.hpp, with the three below
  double fixed_step = 0.01;       ///< ms
  double velocity_kept = 0.9;     ///< share of the velocity that a step leaves
  double velocity_stop = 0.01;    ///< mm/ms, root mean square over the free vertices
};

/// The forces (N), 0 at fixed vertices. In balance the residual is small. The elastic force is the residual minus the
/// other three.
struct Balance {
  Vectors pressure, contact, foundation, residual;
};

/// Couplings between bodies, added to their own forces.
struct Interactions {
  std::vector<SurfaceContact> contacts;
  std::vector<SelfContact> self_contacts; ///< of bodies whose layers lie on one another
  std::vector<Tie> ties;
  std::shared_ptr<SurfaceTrees> trees = std::make_shared<SurfaceTrees>(); ///< for the contacts to share
  /// If set, called after each step with the number of steps done and the forces (empty in textbook integration).
  std::function<void(int, const Balance&)> after_step;
  /// Ends the contacts of a body.
  void forget(int body);
  /// All active contact points. @param ahead ms over which a time-averaged law follows the velocities
  void detect(const System& system, const Vectors& normals, std::vector<ContactPoint>& points, double ahead = 0);
};

/// Where the largest force is left unbalanced.
struct Imbalance {
  double force = 0; ///< N
  int vertex = -1;
};

struct RelaxResult {
  bool converged = false;
  bool stalled = false; ///< gave up after stalled_steps without a lower residual
  Imbalance imbalance;  ///< only where it did not converge
  int steps = 0, cg_iterations = 0, contacts = 0;
  int careful_from = -1; ///< the step after which oscillating vertices were damped, for want of progress; -1: none
  double residual = 0;
  double maximal_penetration = 0, mean_penetration = 0; ///< mm, over the contact points; gaps above 0 count as 0
  std::array<int, 2> deepest{-1, -1}; ///< the vertex of the maximal penetration, and a vertex of the surface it crosses
};

/// Steps towards the balance of forces, by one PCG solve each:
///   (M / h^2 + c A / h + (1 + b / h) K) dx = f + M v / h
/// It ends when the residual over the free vertices is at most the tolerance:
///   ||f|| / ||f_pressure + f_contact + f_foundation||
/// It also ends when the residual has not fallen by a tenth for stalled_steps. The step h follows the displacement that
/// one vertex in a hundred exceeds. Once h > 0.5 ms the motion is quasi-static, and the velocity is dropped.
/// @param balance if given, receives the forces at balance
RelaxResult relax(System& system, Interactions& interactions, const IntegratorSettings& settings,
                  Balance* balance = nullptr);

} // namespace vci
