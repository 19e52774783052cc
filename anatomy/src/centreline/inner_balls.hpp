// The balls inscribed in the lumen: circumspheres of the Delaunay tetrahedra of the wall's vertices, and the cheapest
// ways between them (Antiga, Ene-Iordache, Remuzzi 2003).
#pragma once
#include "core/shortest_ways.hpp"
#include "core/types.hpp"

namespace anatomy {

/// The inner balls; neighbours share a Delaunay facet and the way between their centres passes through no end.
struct Balls {
  std::vector<Vec3> centre;   ///< mm
  std::vector<double> radius; ///< mm
  std::vector<std::vector<std::size_t>> neighbours;
};

/// Balls on the inner side of the wall; the caps' inner vertices are left out, so that the diagram runs straight
/// through the ends.
Balls inner_balls(const Mesh& mesh, const std::vector<End>& ends);

/// The cheapest ways (integral of ds/R) from ball `from` to all others.
Ways cheapest_ways(const Balls& balls, std::size_t from);

/// The ball nearest to the end's centre among those that fill at least half of the end. Throws ComputationError if
/// there is none.
std::size_t ball_at(const Balls& balls, const End& end);

} // namespace anatomy
