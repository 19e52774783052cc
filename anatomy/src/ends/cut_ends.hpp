// Rounded ends of a closed surface, and vessels cut across where the user asks.
#pragma once
#include "ends/plane_cut.hpp"
#include "repair/tips.hpp"

namespace anatomy {

/// The tip of a vessel that ends in no cap, and where to cut it flat.
struct RoundedEnd {
  Vertex tip;
  Vec3 at;               ///< of the tip, mm
  Plane plane;           ///< across the axis behind the last ball, where the next section is alike
  double radius = 0;     ///< mm, of the last inscribed ball
  double widest = 0;     ///< mm, the largest ball within half the prominence, as balls at a rough tip are too small
  double prominence = 0; ///< mm along the surface
  bool reached = true;   ///< whether inscribed balls lead to it from the other tips
  std::string why_short; ///< why it is too short to be a vessel; empty if it is long enough
};

/// The tips that stand out by `prominence` mean radii and are not at one of `ends`, the most prominent first. The mesh
/// must be closed, one component and without removed elements. from_both: tips are looked for from either extremity
/// (repair/tips.hpp), which finds short ones. Throws InputError if a tip has no inscribed ball.
std::vector<RoundedEnd> rounded_ends(const Mesh& mesh, const std::vector<End>& ends, double prominence,
                                     bool from_both = false);

/// The tips seen from either extremity that stand out by `prominence` mm and are not at the rim of one of `ends`, the
/// most prominent first, a mean radius apart. The mesh is as for rounded_ends.
std::vector<Tip> tips_beside_ends(const Mesh& mesh, const std::vector<End>& ends, double prominence);

/// Cuts one off. It leaves the opening for cap_open_ends, and garbage in the mesh. Throws InputError if the plane does
/// not separate the tip.
void cut_rounded(Mesh& mesh, const RoundedEnd& end, std::vector<Repair>& repairs);

/// Cuts the vessel across its axis at the point of the axis nearest to each of `points` (mm) and drops the smaller
/// side. `tagged` is the same mesh with its `ends` tagged; both are as for rounded_ends. Throws InputError if a point
/// is more than three radii from the axis, or the plane does not separate the vessel.
void cut_across(Mesh& mesh, const Mesh& tagged, const std::vector<End>& ends, const std::vector<Vec3>& points,
                std::vector<Repair>& repairs);

} // namespace anatomy
