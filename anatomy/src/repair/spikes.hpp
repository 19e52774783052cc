// Single vertices that stand out of the wall, and how rough the wall is.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// Flattens spikes. A spike is a single vertex that stands out of the wall; it is moved onto the quadratic surface
/// fitted to the two rings of vertices round it. Its height over that surface exceeds half an edge, 0.15 mean radii of
/// the lumen, and eight times the scatter of its neighbours. Reports the number, the largest height and its place.
/// `mesh` is closed and tagged; caps and their neighbourhood are not changed.
void flatten_spikes(Mesh& mesh, std::vector<Repair>& repairs);

struct Roughness {
  double rms = 0;         ///< mm, scatter (root mean square) of the vertices about their neighbourhood
  double edge = 0;        ///< mm, mean distance between successive neighbours of a vertex
  Vec3 at = Vec3::Zero(); ///< mm, place of the vertex that stands out most
};

/// The roughness of a closed mesh, caps included. It is the scatter of the vertices' heights over the mean of their
/// neighbours, along the wall's normal. The mean height over the mesh is subtracted, since it comes from curvature.
Roughness roughness_of(const Mesh& mesh);

} // namespace anatomy
