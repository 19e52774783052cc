// A vessel cut across by a plane that reaches no farther than the vessel itself.
#pragma once
#include "core/types.hpp"

namespace anatomy {

struct Plane {
  Vec3 centre, normal; ///< mm; the normal points along the vessel, away from the side to be dropped
  double radius;       ///< mm, of the vessel there
};

constexpr double section_cover = 1.15; ///< half width of the cutting square over the section's reach from its centre
constexpr double half_width = 2;       ///< of the cutting square, in radii: wide enough for ovals, not for neighbours

/// Cuts the mesh across and drops the side that holds `tip`, or the smaller one if `tip` is the null vertex. It makes
/// one opening only; faces keep their tags. Returns the area dropped (mm2); the mesh then holds garbage. Throws
/// InputError with `remedy` if the plane does not separate the two sides.
double cut(Mesh& mesh, const Plane& plane, Vertex tip, const std::string& remedy);

/// As cut, but keeps only the side that holds `vertex`, whatever its size.
double keep_beyond(Mesh& mesh, const Plane& plane, Vertex vertex, const std::string& remedy);

/// Notes a cut in `repairs`: its radius, place and the wall lost (mm2).
void report_cut(std::vector<Repair>& repairs, const std::string& what, const Plane& plane, double lost);

} // namespace anatomy
