// Single vertices that stand out of the wall, and how rough the wall is.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// Moves a vertex of the wall that stands out alone onto the quadratic surface through the two rings of vertices round
/// it. A vertex stands out if its height over that surface exceeds half an edge, eight times the scatter of its
/// neighbours, and 0.15 mean radii. Reports the number, the largest height and its place. `mesh` is closed and tagged;
/// caps and their neighbourhood are not changed.
void flatten_spikes(Mesh& mesh, std::vector<Repair>& repairs);

struct Roughness {
  double rms = 0;         ///< mm, scatter of the wall's vertices about their neighbourhood
  double edge = 0;        ///< mm, mean
  Vec3 at = Vec3::Zero(); ///< the vertex that stands out most
};

/// The wall's roughness, from the distance of each vertex to the mean of its neighbours along the wall's normal. The
/// mean over the mesh is subtracted, since it comes from curvature.
Roughness roughness_of(const Mesh& mesh);

} // namespace anatomy
