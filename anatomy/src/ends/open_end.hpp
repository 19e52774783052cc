// Measures how flat the rim of an open end is, and closes ragged ends for the time being.
#pragma once
#include "ends/plane_cut.hpp"
#include "repair/loops.hpp"

namespace anatomy {

/// An open end as it was found, and the plane for cutting it if it is ragged.
struct OpenEnd {
  Vec3 centre = Vec3::Zero(); ///< mm, centre of the rim
  double area = 0;            ///< mm2, area within the rim, projected on the rim's plane
  double spacing = 0;         ///< mm, mean length of the edges at the rim's corners
  Plane plane; ///< plane of the cut: parallel to the rim's plane, half an edge behind the rim's deepest notch
  Vec3 outermost = Vec3::Zero(); ///< mm, the rim's outermost corner
  double depth = 0;              ///< mm, from `outermost` to the plane: the length of vessel that a cut there loses
  bool ragged = false;           ///< whether flattening the rim would do damage (see open_end)
  int tag = 0;                   ///< tag of its flat cap; 0 for a ragged end, which is closed without flattening
};

constexpr const char* cut_remedy = "cut the end by a plane across the vessel";

/// Measures an open end. Its rim is ragged if flattening it would do one of these:
/// - move a corner by more than an edge or a quarter of the rim's radius;
/// - turn a triangle over, or take more than four fifths of its area.
/// Throws InputError if the end is ragged and a cut would lose more of the vessel than the rim's radius.
OpenEnd open_end(const Mesh& mesh, const Loop& loop);

/// Closes a ragged end for the time being by a fan of triangles. The fan's apex lies outside the rim, clear of the
/// wall. If the loop passes a corner twice, CGAL fills the hole instead. Returns the new faces, none if the end cannot
/// be closed.
std::vector<Face> close_unflattened(Mesh& mesh, const Loop& loop, const OpenEnd& end);

} // namespace anatomy
