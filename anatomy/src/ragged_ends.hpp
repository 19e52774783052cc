// Open ends whose rim is a sawtooth, as deleting triangles leaves it: flattening would fold the triangles beside it.
#pragma once
#include "loops.hpp"
#include "plane_cut.hpp"

namespace anatomy {

/// An open end as it was found, and where to cut it if it is ragged.
struct OpenEnd {
  Vec3 centre = Vec3::Zero();
  double area = 0;              ///< within the rim, projected on its plane, mm2
  double spacing = 0;           ///< mean edge at the rim, mm
  Plane plane;                  ///< parallel to the rim's, half an edge behind its deepest notch
  Vec3 foremost = Vec3::Zero(); ///< of the rim's corners the one farthest before the plane, mm
  double depth = 0;             ///< mm, from there to the plane: what a cut there loses of the vessel
  bool ragged = false;          ///< flattening would turn or crush triangles beside the rim
  int tag = 0;                  ///< of its flat cap; 0 where it is ragged, thus filled as it is
};

/// Ragged is a rim of which a corner would move by more than an edge or a quarter of the rim's radius, or by which a
/// triangle would be turned over or lose four fifths of its area. Throws InputError if a cut would then lose more of
/// the vessel than the rim's radius.
OpenEnd open_end(const Mesh& mesh, const Loop& loop);

/// Closes a ragged end for the time being, before its rim and thus clear of the wall behind it: by a fan, or where its
/// loop passes a corner twice as CGAL finds best. Returns the faces, none where it cannot.
std::vector<Face> closed_as_it_is(Mesh& mesh, const Loop& loop, const OpenEnd& end);

/// Cuts a closed mesh across behind each end that is ragged, or whose cap the repair of self-intersections has changed,
/// and caps it: at the first plane where the next one, an edge farther in, finds the same section (area and place
/// within 5 %). Each is warned of in `repairs`, with what it loses. Throws InputError where none of six planes does.
void cut_ragged(Mesh& mesh, const std::vector<OpenEnd>& ends, std::vector<Repair>& repairs);

} // namespace anatomy
