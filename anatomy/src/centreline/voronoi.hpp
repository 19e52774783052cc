// Paths from the inlet to the outlets on the Voronoi diagram of the wall's vertices, as in VMTK. The nodes are the
// centres of the Delaunay spheres inside the lumen. The cost of a path is the integral of ds/R (Antiga, Ene-Iordache,
// Remuzzi 2003).
#pragma once
#include "core/types.hpp"

namespace anatomy {

struct Path {
  std::vector<Vec3> points;   ///< mm, centres of the spheres, from the inlet on
  std::vector<double> radius; ///< mm, of the sphere at each point
};

/// Returns one path per end, in the order of `ends`. The path of the end with the index `inlet` is empty. The caps'
/// inner vertices are left out, so that the diagram runs straight through the ends. Throws ComputationError if an end
/// cannot be reached.
std::vector<Path> voronoi_paths(const Mesh& mesh, const std::vector<End>& ends, std::size_t inlet);

} // namespace anatomy
