// The spheres inscribed in the lumen, and the cheapest paths through them. The spheres are circumspheres of the
// Delaunay tetrahedra of the wall's vertices (Antiga, Ene-Iordache, Remuzzi 2003).
#pragma once
#include "core/shortest_paths.hpp"
#include "core/types.hpp"

namespace anatomy {

/// The inscribed spheres. Two spheres are neighbours if their tetrahedra share a facet and the line between their
/// centres passes through no end's cap.
struct InscribedSpheres {
  std::vector<Vec3> centre;                         ///< mm
  std::vector<double> radius;                       ///< mm
  std::vector<std::vector<std::size_t>> neighbours; ///< indices of each sphere's neighbours
};

/// Returns the spheres inside the lumen of a tagged mesh. The caps' inner vertices are left out, so that the Voronoi
/// diagram runs straight through the ends.
/// @param every n, to use only every n-th vertex. No sphere becomes smaller by this, some become larger.
InscribedSpheres inscribed_spheres(const Mesh& mesh, const std::vector<End>& ends, std::size_t every = 1);

/// The cheapest paths from sphere `from` to all others. The cost of a path is the integral of ds / R.
ShortestPaths cheapest_paths(const InscribedSpheres& spheres, std::size_t from);

/// Whether a chain of neighbours leads from sphere `from` to a sphere farther than `reach` (mm) from p. Wall points on
/// one circle or one sphere, as at a flat rim or a round end, form tetrahedra among themselves. The positions of their
/// circumspheres are rounding errors, and no neighbour leads away from them.
/// @param seen flags of the spheres that the search leaves out; the search flags the spheres that it visits, too
bool leads_away(const InscribedSpheres& spheres, std::size_t from, const Vec3& p, double reach,
                std::vector<bool>& seen);

/// Returns the sphere nearest to the end's centre that fills the end and leads into the vessel. Its radius is more than
/// half of the end's, and its centre is within two of the end's radii. A chain of its neighbours leads farther from the
/// end than the end's radius. Throws ComputationError if there is none.
std::size_t sphere_at_end(const InscribedSpheres& spheres, const End& end);

} // namespace anatomy
