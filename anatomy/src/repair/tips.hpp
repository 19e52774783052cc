// The extremities of a closed surface, at which its vessels end, for ends of any shape.
#pragma once
#include "core/types.hpp"

namespace anatomy {

struct Tip {
  Vertex vertex;
  double prominence = 0;     ///< mm along the surface from the tip to where its vessel joins a longer one
  bool is_extremity = false; ///< one of the two ends of the longest way; `prominence` is then its length
};

/// Vertices whose distance along the edges from the farthest extremity is a local maximum of at least this prominence
/// (zero-dimensional persistence of the distance), and the extremity itself; the most prominent first. A branch that
/// leans back towards the extremity has little or no prominence. from_far_end: distances are from the vertex farthest
/// from the extremity. The mesh must be one component without removed elements.
std::vector<Tip> tips_of(const Mesh& mesh, double least_prominence, bool from_far_end = false);

/// Vertices on handles, the farthest first; none if the closed mesh has no handle. At these vertices the region farther
/// from an extremity closes to a loop, as on no tree. The mesh must be one component without removed elements.
std::vector<Vertex> places_on_handles(const Mesh& mesh);

} // namespace anatomy
