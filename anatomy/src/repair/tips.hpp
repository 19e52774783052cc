// The extremities of a closed surface: where its vessels end, whatever the shape of their ends.
#pragma once
#include "core/types.hpp"

namespace anatomy {

struct Tip {
  Vertex vertex;
  double prominence = 0; ///< mm along the surface from the tip to where its vessel joins a longer one
};

/// Vertices whose distance along the edges from the farthest extremity is a local maximum of at least this prominence
/// (zero-dimensional persistence of that distance), that extremity included; the most prominent first. The mesh must
/// be one component without removed elements. from_far_end: the distance is that from the vertex farthest from that
/// extremity. A branch that leans back towards where the distance starts stands out by little or nothing.
std::vector<Tip> tips_of(const Mesh& mesh, double least_prominence, bool from_far_end = false);

/// Vertices on handles (where the distance from an extremity closes a loop that the surface of a tree would not have),
/// the farthest first; none if the closed mesh has no handle. The mesh must be one component without removed elements.
std::vector<Vertex> places_on_handles(const Mesh& mesh);

} // namespace anatomy
