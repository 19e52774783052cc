// The tips of a closed surface, at which its vessels end, whatever the shape of the ends.
#pragma once
#include "core/types.hpp"

namespace anatomy {

struct Tip {
  Vertex vertex;
  double prominence = 0;     ///< mm along the surface from the tip to where its vessel joins a longer one
  bool is_extremity = false; ///< one of the two ends of the longest path; `prominence` is then the path's length
};

/// The tips, the most prominent first. Distances along the edges are measured from an extremity of the surface. A tip
/// is a local maximum of the distance with at least this prominence (zero-dimensional persistence). The extremity
/// itself is a tip too. A branch that leans back towards the extremity has little or no prominence. The mesh must be
/// one component without removed elements.
/// @param least_prominence mm
/// @param from_far_end measure from the opposite extremity, the vertex farthest from the usual one
std::vector<Tip> tips_of(const Mesh& mesh, double least_prominence, bool from_far_end = false);

/// Vertices on handles, the farthest from an extremity first; none if the closed mesh has no handle. At such a vertex
/// the part of the surface that is farther from the extremity closes to a loop, which never happens on a tree. The mesh
/// must be one component without removed elements.
std::vector<Vertex> places_on_handles(const Mesh& mesh);

} // namespace anatomy
