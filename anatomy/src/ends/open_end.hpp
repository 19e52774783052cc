// Openings of a surface that are ends of the vessel: how flat their rims are.
#pragma once
#include "ends/plane_cut.hpp"
#include "repair/loops.hpp"

namespace anatomy {

/// An open end as it was found, and where to cut it if it is ragged.
struct OpenEnd {
  Vec3 centre = Vec3::Zero();
  double area = 0;              ///< within the rim, projected on its plane, mm2
  double spacing = 0;           ///< mean edge at the rim, mm
  Plane plane;                  ///< parallel to the rim's plane, half an edge behind the rim's deepest notch
  Vec3 foremost = Vec3::Zero(); ///< mm, the rim's corner farthest before the plane
  double depth = 0;             ///< mm, from `foremost` to the plane: the length of vessel that a cut there loses
  bool ragged = false;          ///< flattening would turn or crush triangles beside the rim
  int tag = 0;                  ///< of its flat cap; 0 for a ragged end, which is closed as it is
};

constexpr const char* cut_remedy = "cut the end by a plane across the vessel";

/// A rim is ragged where flattening it would do one of these: move a corner by more than an edge or a quarter of the
/// rim's radius, turn a triangle over, or take four fifths of its area. Throws InputError if a cut would then lose more
/// of the vessel than the rim's radius.
OpenEnd open_end(const Mesh& mesh, const Loop& loop);

/// Closes a ragged end for the time being by a fan. The fan's apex lies before the rim, clear of the wall behind it. If
/// the loop passes a corner twice, CGAL fills the hole instead. Returns the new faces, none if it cannot be closed.
std::vector<Face> closed_as_it_is(Mesh& mesh, const Loop& loop, const OpenEnd& end);

} // namespace anatomy
