// One-sided contact between an inner and an outer surface, and ties that keep a contact point together.
#pragma once
#include "vci/geometry/broad_phase.hpp"
#include "vci/linalg/pcg.hpp"
#include "vci/mechanics/system.hpp"

#include <map>

namespace vci {

struct ContactSettings {
  double stiffness = 60.0;         ///< kappa, MPa/mm
  double distance = 0.0125;        ///< delta, mm: contact begins at this gap
  double ramp = 0.02;              ///< w, mm
  double skin = 0.2;               ///< mm
  double friction = 0.1;           ///< Coulomb's mu
  double friction_stiffness = 2.0; ///< MPa/mm: tangential stress per slip below the limit
  bool smooth = true;         ///< the surface through the triangles' corners (sagitta); false: the triangles themselves
  bool time_averaged = false; ///< eq 18: the law's mean over the gaps of a step, where the velocity is followed
};

/// The share of each stiffness that is left near a surface's edge: 1 inside, 0 at the edge. A contact that ended
/// abruptly would switch on and off for ever. The ordinary stiffness fades over the last row of triangles. Before the
/// rim of a window, the deep stiffness fades only at the very end of that row.
struct ContactFade {
  double ordinary = 1, deep = 1; ///< `deep` includes the factor of stiffen_deep_contacts()
};

/// The penalty law at a gap. With the overlap a = delta - gap, the pressure is kappa a^2 / (2 w) below a = w and
/// kappa (a - w / 2) above. A second response with 40 kappa and 2 w is added from a = 1.5 w on.
struct PenaltyResponse {
  double energy, pressure, stiffness; ///< per area: N/mm, MPa, MPa/mm
};
PenaltyResponse penalty_response(double gap, const ContactSettings& settings, const ContactFade& fade = {});
/// The mean response while the gap goes evenly from one value to another (equation 18). The law of equation 19 takes
/// the signed gap here. The unsigned distance would pull a surface that has passed through another further through.
PenaltyResponse averaged_response(double from, double to, const ContactSettings& settings,
                                  const ContactFade& fade = {});

/// A vertex in contact with a triangle. The gap is n . sum(w_k x_k), with n the triangle's interpolated normal. The gap
/// turns negative when the surfaces cross, so that no vertex can tunnel. Normal and weights are constant within a step.
struct ContactPoint {
  StencilStiffness stencil;
  double area;   ///< of the vertex, mm^2
  double gap;    ///< mm
  double force;  ///< N along the normal
  Vec3 friction; ///< friction force, N: opposes the slip, at most mu times the normal force
  Vec3* slip;    ///< elastic part of the tangential displacement since first touch, mm; kept by the contact
  double* deep_scale = nullptr; ///< factor on this vertex's deep response, kept by the contact; null: always 1
};

/// Regularised Coulomb friction with an elastic slip, which is mapped back where it passes the limit. Sets the slip,
/// the friction force and the stencil's tangential stiffness. The stiffness is the secant of the trial state, so it is
/// never negative; for a sliding point it is reduced along the slip.
void add_friction(ContactPoint& point, const ContactSettings& settings);

/// How two surfaces lie to each other, and which of their vertices take no part in their contact (flags; empty: none).
/// A projection onto a triangle of excluded vertices does not count, like one beyond an open edge.
struct ContactSides {
  bool nested = true; ///< false: side by side, the outward normals face each other
  std::vector<char> inner_excluded, outer_excluded;
  /// The outer vertices round a window. The surface fades out towards them, as towards an end, but they meet the inner
  /// surface like any others. If it faded out towards excluded vertices, these would bear the load of the last row of
  /// triangles and hold nothing off themselves. A device would then rise through the window and lie over the edge.
  std::vector<char> outer_rim = {};
};

/// Area vectors of all vertices (mm^2), and the unit vectors along them.
struct Normals {
  Vectors area, unit;
  Normals(Vectors areas); // NOLINT(google-explicit-constructor) ; area vectors are all there is to say
};

/// Trees of bounding boxes, one for each body's surface, shared by several contacts.
class SurfaceTrees {
public:
  /// The tree of a body, fitted to the system's positions as far as a search needs.
  const BroadPhase& at(const System& system, int body);
  void forget(int body) { trees_.erase(body); }

private:
  std::map<int, BroadPhase> trees_;
};

/// Contact of inner vertices with outer triangles, and of outer vertices with inner triangles. The normals of both
/// surfaces point outwards. Candidates come from the broad phase. The search and the gap of a vertex are repeated only
/// once it and the other surface may have moved far enough to change the result.
class SurfaceContact {
public:
  /// @param trees shared with the other contacts of the same system; null: the contact makes its own
  SurfaceContact(int inner, int outer, const ContactSettings& settings, ContactSides sides = {},
                 std::shared_ptr<SurfaceTrees> trees = {})
      : inner_(inner), outer_(outer), settings_(settings), sides_(std::move(sides)),
        trees_(trees ? std::move(trees) : std::make_shared<SurfaceTrees>()) {}
  int inner() const { return inner_; }
  int outer() const { return outer_; }
  /// Appends the active contact points at the system's positions.
  /// @param ahead ms over which a time-averaged law follows the velocities
  void detect(const System& system, const Normals& normals, std::vector<ContactPoint>& points, double ahead = 0);

private:
  /// How far a vertex and the surface that it faces may move together before an earlier result must be computed again.
  struct MotionBound {
    Vec3 place;
    double travel; ///< mm: the surface's total travel when the result was found
    double length; ///< mm: the bound
    bool exceeded(const Vec3& p, double travelled) const { return (p - place).norm() + travelled - travel > length; }
  };
  struct Facing {
    MotionBound search{Vec3::Zero(), 0, -1}, measure = search; ///< -1: at once
    std::vector<int> triangles;
    int last_triangle = -1; ///< the triangle that the vertex met last, or that the search found nearest; -1: none
  };
  struct Direction {
    std::vector<Facing> facing;     ///< per vertex of the source body
    Vectors slip;                   ///< likewise
    std::vector<double> deep_scale; ///< likewise
    double travel = 0;              ///< sum of the target's largest displacements, mm
  };
  void search(const System& system, const Vectors& units, int from, int onto, bool vertex_inside, Direction& side);
  void face(const System& system, const Vectors& units, int v, const Body& target, bool vertex_inside,
            const std::vector<NearTriangle>& found, double travel, Facing& facing) const;
  bool keeps_projection(const System& system, const Vectors& units, const Vec3& p, const Body& target, double travel,
                        const Facing& facing) const;
  void measure(const System& system, const Normals& normals, int from, int onto, bool vertex_inside, double ahead,
               Direction& side, std::vector<ContactPoint>& points) const;
  double largest_move(const System& system, int body) const;
  bool excluded(const System& system, int body, int vertex) const;
  bool open_at(const System& system, int body, int vertex) const;
  ContactFade fade_at(const System& system, int body, const Triangle& t, const Vec3& weights) const;

  int inner_, outer_;
  ContactSettings settings_;
  ContactSides sides_;
  std::shared_ptr<SurfaceTrees> trees_;
  Vectors last_; ///< positions at the last call
  Direction inner_on_outer_, outer_on_inner_;
};

/// A contact point made permanent: force f0 n at the offset r0, with a stiffness along n in both senses and across it.
struct Tie {
  StencilStiffness stencil;
  Vec3 offset;  ///< r0, mm
  double force; ///< f0, N
};
Tie tie_of(const ContactPoint& point, const Vectors& x, double stiffness_mpa_per_mm);
/// Adds the ties' forces.
void add_tie_forces(const std::vector<Tie>& ties, const Vectors& x, Vectors& force);
void add_contact_forces(const std::vector<ContactPoint>& points, Vectors& force);
/// Doubles the deep response of the vertices that lie deeper than a limit (mm), until a bound. Returns whether any was
/// doubled. Repeated after each balance, this penalty update brings the penetration below the limit.
bool stiffen_deep_contacts(const std::vector<ContactPoint>& points, double limit);
/// Adds a step's displacements to the slip of the contact points; detect() maps it back to the friction limit.
void add_slip(const std::vector<ContactPoint>& points, const Vectors& displacement);

/// Area vectors of all vertices of all bodies.
Vectors area_vectors(const System& system);

} // namespace vci
