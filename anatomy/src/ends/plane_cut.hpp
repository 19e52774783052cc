// Cuts a vessel across by a square that is large enough for the vessel, but does not reach far beyond it.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// The plane of a cut.
struct Plane {
  Vec3 centre, normal; ///< mm; unit normal along the vessel, which points away from the side to be dropped
  double radius;       ///< radius (mm) of the vessel there, which sets the size of the cutting square
};

/// Least ratio of the cutting square's half width to the section's farthest distance from the plane's centre.
constexpr double section_cover = 1.15;
/// Half width of the cutting square, in radii of the plane: wide enough for oval vessels, not for neighbouring ones.
constexpr double square_half_width = 2;

/// Cuts the mesh across and drops the side that holds the vertex `tip`, or the smaller side if `tip` is the null
/// vertex. The cut leaves one opening, and faces keep their tags. Returns the area dropped (mm2); the mesh then holds
/// removed elements. Throws InputError with `remedy` if the plane does not separate the sides, or if it drops more than
/// half of the area.
double cut_at_plane(Mesh& mesh, const Plane& plane, Vertex tip, const std::string& remedy);

/// Cuts as cut_at_plane() does, but keeps the side that holds `vertex`, whatever its size. Returns the area dropped in
/// mm2.
double cut_and_keep(Mesh& mesh, const Plane& plane, Vertex vertex, const std::string& remedy);

/// Adds an entry named `what` to `repairs`, with the cut's radius, its place and the area `lost` (mm2).
void report_cut(std::vector<Repair>& repairs, const std::string& what, const Plane& plane, double lost);

} // namespace anatomy
