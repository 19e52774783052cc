// Paths from the inlet to the outlets on the Voronoi diagram of the wall's vertices, as VMTK does it: the centres of
// Delaunay balls inside the lumen are the nodes, the integral of ds/R is the cost (Antiga, Ene-Iordache, Remuzzi 2003).
#pragma once
#include "core/types.hpp"

namespace anatomy {

struct Path {
  std::vector<Vec3> points;   ///< from the inlet, mm
  std::vector<double> radius; ///< of the Delaunay ball, mm
};

/// One path per end, in the order of `ends`; the inlet's is empty. The caps' inner vertices are left out, so that the
/// diagram runs straight through the ends. Throws ComputationError if an end cannot be reached.
std::vector<Path> voronoi_paths(const Mesh& mesh, const std::vector<End>& ends, std::size_t inlet);

} // namespace anatomy
