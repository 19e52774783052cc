// Finds force balance by pseudo-transient backward Euler.
#pragma once
#include "vci/contact/self_contact.hpp"

#include <functional>

namespace vci {

struct IntegratorSettings {
  double residual_tolerance = 3e-3;  ///< residual (see relax()) at which a stage is in balance
  double maximal_penetration = 0.05; ///< mm: if contacts are deeper in balance, they are stiffened and the steps go on
  double displacement_per_step = 0.12; ///< mm: displacement that the length of the next step aims at
  double initial_step = 0.3;           ///< ms, first step of a stage
  double maximal_step = 200.0;         ///< ms
  int maximal_steps = 1500;            ///< largest number of steps in a stage
  int stalled_steps = 300; ///< a stage gives up after so many steps without progress; care restarts the count once
  PcgSettings pcg{0.2, 300, 24, true};
  double damping = 2.5;           ///< c, MPa ms/mm: damping force per area and velocity
  double stiffness_damping = 0.0; ///< b, ms: damping matrix over stiffness matrix
  bool textbook = false;          ///< use the scheme of textbook.hpp, with the three settings below
  double fixed_step = 0.01;       ///< ms
  double velocity_kept = 0.9;     ///< share of the velocity that remains after a step; no setting of scenes
  double velocity_stop = 0.01;    ///< mm/ms: root mean square over the free vertices at which a stage ends
};

/// Forces on each vertex (N), 0 at fixed vertices. `residual` is the sum of all forces, elastic ones included. It is
/// small in balance.
struct Balance {
  Vectors pressure, contact, foundation, residual;
};

/// Contacts and ties, which act between bodies in addition to the bodies' own forces.
struct Interactions {
  std::vector<SurfaceContact> contacts;
  std::vector<SelfContact> self_contacts; ///< contacts of folded bodies with themselves
  std::vector<Tie> ties;
  std::shared_ptr<SurfaceTrees> trees = std::make_shared<SurfaceTrees>(); ///< shared by the contacts
  /// If set, called after each step with the number of steps done and the forces (empty in textbook integration).
  std::function<void(int, const Balance&)> after_step;
  /// Removes the contacts and the search tree of a body.
  void remove_body(int body);
  /// Appends all active contact points to `points`.
  /// @param normals area vectors of all vertices
  /// @param lookahead_ms time (ms) over which a time-averaged law predicts the gap from the velocities
  void detect(const System& system, const Vectors& normals, std::vector<ContactPoint>& points, double lookahead_ms = 0);
};

/// The free vertex with the largest net force.
struct Imbalance {
  double force = 0; ///< N
  int vertex = -1;
};

struct RelaxResult {
  bool converged = false;
  bool stalled = false; ///< given up because the residual had not fallen by a tenth for stalled_steps
  Imbalance imbalance;  ///< set only if the stage was given up
  int steps = 0, cg_iterations = 0, contacts = 0;
  int careful_from = -1; ///< step from which linear solves were more accurate for lack of progress; -1: never
  double residual = 0;   ///< see relax()
  double maximal_penetration = 0, mean_penetration = 0; ///< mm, over the contact points; gaps above 0 count as 0
  std::array<int, 2> deepest{-1, -1}; ///< the deepest vertex, and a vertex of the surface that it has crossed
};

/// Takes steps towards the balance of forces. Each step is one PCG solve for the displacements dx:
///   (M / h^2 + c A / h + (1 + b / h) K) dx = f + M v / h
/// with lumped mass M, area A of each vertex, stiffness K, forces f, velocities v, and the damping constants c and b.
/// The steps end when this residual over the free vertices is at most the tolerance:
///   ||f|| / ||f_pressure + f_contact + f_foundation||
/// They also end when the residual has not fallen by a tenth for stalled_steps, or after maximal_steps. The step length
/// h is adapted to the displacement that one vertex in a hundred exceeds. Above h = 0.5 ms the motion is quasi-static:
/// the velocity is dropped.
/// @param balance if given, receives the forces at balance
RelaxResult relax(System& system, Interactions& interactions, const IntegratorSettings& settings,
                  Balance* balance = nullptr);

/// The residual and the contacts of the current state. Takes no step and stiffens no contact.
/// @param balance if given, receives the forces, whether they balance or not
RelaxResult measure_balance(System& system, Interactions& interactions, Balance* balance = nullptr);

} // namespace vci
