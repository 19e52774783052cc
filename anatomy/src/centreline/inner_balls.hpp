// The balls inscribed in the lumen: circumspheres of the Delaunay tetrahedra of the wall's vertices, and the cheapest
// ways between them (Antiga, Ene-Iordache, Remuzzi 2003).
#pragma once
#include "core/shortest_ways.hpp"
#include "core/types.hpp"

namespace anatomy {

/// The inscribed balls. Neighbours share a Delaunay facet, and the line between their centres passes through no end.
struct Balls {
  std::vector<Vec3> centre;   ///< mm
  std::vector<double> radius; ///< mm
  std::vector<std::vector<std::size_t>> neighbours;
};

/// Balls on the inner side of the wall. The caps' inner vertices are left out, so that the diagram runs straight
/// through the ends.
/// @param every uses only every n-th vertex. No ball becomes smaller by this, some become larger.
Balls inner_balls(const Mesh& mesh, const std::vector<End>& ends, std::size_t every = 1);

/// The cheapest ways (integral of ds/R) from ball `from` to all others.
Ways cheapest_ways(const Balls& balls, std::size_t from);

/// Whether neighbours lead from the ball to a ball farther than `reach` (mm) from p. Wall points on one circle or one
/// sphere, as at a flat rim or a round end, form tetrahedra among themselves. The positions of their circumspheres are
/// rounding errors, and no neighbour leads away from them.
/// @param seen flags the balls already visited; it is extended
bool leads_away(const Balls& balls, std::size_t from, const Vec3& p, double reach, std::vector<bool>& seen);

/// The ball nearest to the end's centre among those that fill at least half of the end and from which a way leads
/// farther inwards than the end's radius. Throws ComputationError if there is none.
std::size_t ball_at(const Balls& balls, const End& end);

} // namespace anatomy
