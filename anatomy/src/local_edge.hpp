// Shorter edges where the vessel is narrowed, so that a throat has as many edges round it as the healthy vessel.
#pragma once
#include "lesions.hpp"

namespace anatomy {

constexpr double smallest_edge_factor = 0.3;

/// R / R_reference at the axis point nearest to p, within [smallest_edge_factor, 1]: the edge there over the edge in
/// the healthy vessel. An edge that is uniform leaves a throat of a third of the radius with a third of the edges, and
/// it stays that coarse polygon once it has been opened.
double edge_factor(const std::vector<Branch>& branches, const std::vector<ReferenceProfile>& profiles, const Vec3& p);

/// A copy of the uniform, tagged `mesh` of edge `edge` (mm) whose wall is remeshed, in nested steps of 0.85, to
/// edge * edge_factor where that is below 1. Wall vertices are projected on the wall of `surface`, the smooth one that
/// `mesh` was made from; caps, rims and the wall's triangles at the rims stay. Throws ComputationError as remeshed().
Mesh refined_at_throats(const Mesh& mesh, const Mesh& surface, double edge, const std::vector<Branch>& branches,
                        const std::vector<ReferenceProfile>& profiles);

} // namespace anatomy
