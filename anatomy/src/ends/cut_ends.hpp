// Cuts rounded ends of a closed surface flat, and cuts vessels across where the user asks.
#pragma once
#include "ends/plane_cut.hpp"
#include "repair/tips.hpp"

namespace anatomy {

/// The tip of a vessel that has no flat cap, and the plane that cuts the vessel flat behind the tip.
struct RoundedEnd {
  Vertex tip;
  Vec3 position; ///< mm, position of the tip
  Plane plane;   ///< plane of the cut, across the axis behind the last sphere, where the section's area changes little
  double radius = 0; ///< radius (mm) of the last inscribed sphere before the tip
  /// Radius (mm) of the largest sphere on the axis up to half the prominence from the last sphere. At a rough tip the
  /// last sphere itself is too small.
  double widest_sphere = 0;
  double prominence = 0;        ///< prominence (mm along the surface) of the tip, see Tip in repair/tips.hpp
  bool is_reachable = true;     ///< whether a path through inscribed spheres leads from another tip to this one
  std::string too_short_reason; ///< why the vessel is too short to have an end; empty if it is long enough
};

/// Returns the tips whose prominence is at least `prominence` mean radii and that lie at none of the tagged `ends`. The
/// most prominent comes first; of tips with the same cut only one is returned. The mesh must be closed, one component
/// and without removed elements. With from_both, tips are sought by the distance from either extremity of the surface
/// (repair/tips.hpp); this also finds short tips. Throws InputError if no inscribed sphere is near a tip.
std::vector<RoundedEnd> rounded_ends(const Mesh& mesh, const std::vector<End>& ends, double prominence,
                                     bool from_both = false);

/// Returns the tips whose prominence is at least `prominence` mm and that lie at no rim of the tagged `ends`. Tips are
/// sought by the distance from either extremity. The most prominent comes first. Any two are at least a mean radius
/// apart. The mesh must meet the same conditions as for rounded_ends.
std::vector<Tip> tips_beside_ends(const Mesh& mesh, const std::vector<End>& ends, double prominence);

/// Cuts `end` off. This leaves an opening for cap_open_ends, and removed elements in the mesh. Throws InputError if the
/// plane does not separate the tip from the rest.
void cut_rounded(Mesh& mesh, const RoundedEnd& end, std::vector<Repair>& repairs);

/// For each of `points` (mm), cuts the vessel across at the nearest point of its axis, and drops the side with the
/// smaller area. `tagged` is the same mesh with its `ends` tagged; both must meet the conditions of rounded_ends.
/// Throws InputError if a point is more than three radii from the axis, or if the plane does not separate the vessel
/// into two parts.
void cut_across(Mesh& mesh, const Mesh& tagged, const std::vector<End>& ends, const std::vector<Vec3>& points,
                std::vector<Repair>& repairs);

} // namespace anatomy
