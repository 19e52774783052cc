// Contact with friction between an inner and an outer surface, and ties that make contact points permanent.
#pragma once
#include "vci/geometry/broad_phase.hpp"
#include "vci/linalg/pcg.hpp"
#include "vci/mechanics/system.hpp"

#include <map>

namespace vci {

struct ContactSettings {
  double stiffness = 60.0;  ///< kappa, MPa/mm: contact pressure per overlap, beyond the ramp
  double distance = 0.0125; ///< delta, mm: contact begins at this gap
  double ramp = 0.02;       ///< w, mm: overlap over which the stiffness rises from 0 to kappa
  double skin = 0.2; ///< mm: nearby triangles are searched again once vertex and surface have together moved by this
  double friction = 0.1;           ///< Coulomb's coefficient mu
  double friction_stiffness = 2.0; ///< MPa/mm: tangential stress per slip below the friction limit
  /// Gaps are measured to the smooth surface through the triangles' corners (see sagitta()); false: to flat triangles.
  bool smooth = true;
  /// Textbook scheme only: the pressure is its mean over a step, predicted from the velocities (averaged_response()).
  bool time_averaged = false;
};

/// Factors on the two contact stiffnesses near a surface's edge: 1 inside, 0 at the edge. If contact ended abruptly at
/// the edge, a vertex there would gain and lose contact for ever. The ordinary stiffness fades over the last row of
/// triangles. Before the rim of a window (an opening in a surface), the deep stiffness fades only over the last tenth
/// of that row.
struct ContactFade {
  double ordinary = 1, deep = 1; ///< `deep` includes the factor of stiffen_deep_contacts()
};

/// The response of the penalty law to a gap (mm). With the overlap a = delta - gap, the pressure is kappa a^2 / (2 w)
/// for a below w, and kappa (a - w / 2) above. A second, deep response with stiffness 40 kappa and ramp 2 w is added
/// from a = 1.5 w on.
struct PenaltyResponse {
  double energy, pressure, stiffness; ///< per area: N/mm, MPa, MPa/mm
};
PenaltyResponse penalty_response(double gap, const ContactSettings& settings, const ContactFade& fade = {});
/// The mean response while the gap (mm) changes evenly from `from` to `to` (equation 18 of Lyu et al. 2025). Their
/// equation 19 is applied to the signed gap here. The unsigned distance would pull a surface that has passed through
/// another further through.
PenaltyResponse averaged_response(double from, double to, const ContactSettings& settings,
                                  const ContactFade& fade = {});

/// A vertex in contact with a triangle. The gap is n . sum(w_k x_k), with n the triangle's interpolated normal. Smooth
/// contact corrects the gap by the sagitta. The gap turns negative when the surfaces cross, so that a vertex that has
/// passed through is pushed back. Normal and weights are constant within a step.
struct ContactPoint {
  StencilStiffness
      stencil;   ///< the vertex and the triangle's corners with their weights w_k, and the contact's stiffness
  double area;   ///< area of the vertex, mm^2; reduced near an edge by ContactFade::ordinary
  double gap;    ///< mm
  double force;  ///< N along the normal
  Vec3 friction; ///< friction force, N: opposes the slip, at most mu times the normal force
  Vec3* slip;    ///< tangential displacement (mm) that friction resists; stored by the SurfaceContact
  double* deep_scale = nullptr; ///< factor on this vertex's deep response; stored by the SurfaceContact; null: always 1
};

/// Coulomb friction with an elastic slip. The friction force grows with the slip; beyond the friction limit the slip is
/// shortened until the force equals the limit. Sets the slip, the friction force and the stencil's tangential
/// stiffness. The stiffness is a secant, the force divided by the slip before shortening, so it is never negative. For
/// a sliding point the stiffness along the slip is reduced.
void add_friction(ContactPoint& point, const ContactSettings& settings);

/// How two surfaces lie to each other, and which of their vertices take no part in their contact. The lists hold a flag
/// for each vertex of a body; an empty list flags none. A vertex that projects onto a triangle whose three corners are
/// all excluded is not in contact, as if it projected beyond an open edge.
struct ContactScope {
  bool nested = true; ///< one surface inside the other; false: side by side, with outward normals towards each other
  std::vector<char> inner_excluded, outer_excluded;
  /// Vertices of the outer surface round a window. Contact of the inner vertices fades out towards this rim, as towards
  /// an open end. The rim's own vertices meet the inner surface like any others. The fade must not end at the excluded
  /// vertices instead: they would take load from the last row of triangles, but cannot hold a device off. A device
  /// would rise through the window and lie over its edge.
  std::vector<char> outer_rim = {};
};

/// Area vectors of all vertices (mm^2), and the unit vectors along them.
struct Normals {
  Vectors area, unit;
  Normals(Vectors areas); // NOLINT(google-explicit-constructor) ; the area vectors determine all members
};

/// Trees of bounding boxes, one for each body's surface, shared by several contacts.
class SurfaceTrees {
public:
  /// The tree of a body, updated to the system's current positions (see BroadPhase::update()).
  const BroadPhase& at(const System& system, int body);
  void remove_body(int body) { trees_.erase(body); }

private:
  std::map<int, BroadPhase> trees_;
};

/// Contact of inner vertices with outer triangles, and of outer vertices with inner triangles. The normals of both
/// surfaces point outwards. Candidate triangles come from the broad phase. For each vertex, the search and the gap are
/// repeated only once the vertex and the other surface may have moved far enough to change the result.
class SurfaceContact {
public:
  /// @param inner, outer numbers of the two bodies in the system
  /// @param trees search trees that the contacts of a system share; null: the contact makes separate trees
  SurfaceContact(int inner, int outer, const ContactSettings& settings, ContactScope scope = {},
                 std::shared_ptr<SurfaceTrees> trees = {})
      : inner_(inner), outer_(outer), settings_(settings), scope_(std::move(scope)),
        trees_(trees ? std::move(trees) : std::make_shared<SurfaceTrees>()) {}
  int inner() const { return inner_; }
  int outer() const { return outer_; }
  /// Appends the active contact points at the system's positions.
  /// @param lookahead_ms time (ms) over which a time-averaged law predicts the gap from the velocities
  void detect(const System& system, const Normals& normals, std::vector<ContactPoint>& points, double lookahead_ms = 0);

private:
  /// Tells until when an earlier search or gap is still valid: until the motions of the vertex and of the other surface
  /// add up to more than `allowance`.
  struct MotionBound {
    Vec3 position;    ///< position of the vertex when the result was found, mm
    double travel;    ///< OneWayContact::travel when the result was found, mm
    double allowance; ///< mm; below 0: the result must be computed again at once
    bool exceeded(const Vec3& p, double travelled) const {
      return (p - position).norm() + travelled - travel > allowance;
    }
  };
  /// The triangles of the other surface that lie near a vertex.
  struct Candidates {
    MotionBound search_bound{Vec3::Zero(), 0, -1},
        gap_bound = search_bound; ///< when to search again, and when to measure the gap again
    std::vector<int> triangles;   ///< candidates for contact; empty: the surface is far
    int last_triangle = -1;       ///< the triangle that the vertex met last, or that the search found nearest; -1: none
  };
  /// Contact of one body's vertices with the other body's triangles.
  struct OneWayContact {
    std::vector<Candidates> candidates; ///< one for each vertex
    Vectors slip;                       ///< slip of each vertex, mm
    std::vector<double> deep_scale;     ///< factor on the deep response of each vertex
    double travel = 0;                  ///< sum over all calls of the largest displacement of the other body, mm
  };
  void search_candidates(const System& system, const Vectors& unit_normals, int from, int onto, bool vertex_inside,
                         OneWayContact& one_way);
  void store_candidates(const System& system, const Vectors& unit_normals, int v, const Body& target,
                        bool vertex_inside, const std::vector<NearTriangle>& found, double travel,
                        Candidates& candidates) const;
  bool still_projects(const System& system, const Vectors& unit_normals, const Vec3& p, const Body& target,
                      double travel, const Candidates& candidates) const;
  void measure_gaps(const System& system, const Normals& normals, int from, int onto, bool vertex_inside,
                    double lookahead_ms, OneWayContact& one_way, std::vector<ContactPoint>& points) const;
  double largest_displacement(const System& system, int body) const;
  bool excluded(const System& system, int body, int vertex) const;
  bool lies_at_window(const System& system, int body, int vertex) const;
  ContactFade fade_at(const System& system, int body, const Triangle& t, const Vec3& weights) const;

  int inner_, outer_;
  ContactSettings settings_;
  ContactScope scope_;
  std::shared_ptr<SurfaceTrees> trees_;
  Vectors last_positions_; ///< positions of all vertices at the last detect(), mm
  OneWayContact inner_on_outer_, outer_on_inner_;
};

/// A contact point made permanent. At the offset r0 the tie exerts the contact's force f0 n, with n the normal. Springs
/// resist every change of the offset: apart, together and tangential.
struct Tie {
  StencilStiffness stencil; ///< stencil of the contact point, with the stiffness of the springs
  Vec3 offset;              ///< r0: weighted sum of the stencil's positions, mm
  double force;             ///< f0, N
};
/// The tie of a contact point at positions x.
Tie make_tie(const ContactPoint& point, const Vectors& x, double stiffness_mpa_per_mm);
/// Adds the ties' forces at positions x (mm) to `force` (N per vertex of the system).
void add_tie_forces(const std::vector<Tie>& ties, const Vectors& x, Vectors& force);
void add_contact_forces(const std::vector<ContactPoint>& points, Vectors& force);
/// Doubles the stiffness of the second contact response (PenaltyResponse) at each vertex that lies deeper in a surface
/// than `limit` (mm), up to 64 times its first value. Returns whether any was doubled. The solver then balances the
/// forces again. Repeated updates of the penalty reduce the penetration.
bool stiffen_deep_contacts(const std::vector<ContactPoint>& points, double limit);
/// Adds a step's displacements (mm) to the slips of the contact points. The next detect() shortens slips that exceed
/// the friction limit.
void add_slip(const std::vector<ContactPoint>& points, const Vectors& displacement);

/// Area vectors of all vertices of all bodies.
Vectors area_vectors(const System& system);

} // namespace vci
