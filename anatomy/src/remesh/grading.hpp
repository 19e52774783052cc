// Remeshes the wall to the edge lengths of a sizing field: shorter edges where the vessel is narrow.
#pragma once
#include "core/types.hpp"
#include "remesh/sizing_field.hpp"
#include <optional>

namespace anatomy {

/// A copy of the tagged `mesh` with the edges that `field` asks for. In `mesh` all edges are about as long as
/// field.edge(). Where `field` asks for shorter ones, the wall is remeshed in steps that shorten the edges by a factor
/// of 0.85. Angles are then widened to 30 degrees. Vertices are projected on the wall of `surface`, the smooth surface
/// that `mesh` was made from. Caps, rims and the wall's triangles at the rims stay. Throws ComputationError if the
/// result crosses itself or is not closed.
Mesh graded(const Mesh& mesh, const Mesh& surface, const SizingField& field);

/// Does the same as graded() for a `mesh` with uniform edges of `edge` mm, shorter than field.edge(), as a narrow
/// throat needs them. Where `field` allows longer edges, the wall is remeshed to them in the same steps.
Mesh coarsened(const Mesh& mesh, double edge, const Mesh& surface, const SizingField& field);

/// Does the same as graded() for a mesh that was graded before and deformed since. The mesh is remeshed only where
/// edges are no longer 0.5 to 1.6 times the wanted length or angles are below 30 degrees, and next to these places.
/// Returns nothing if this concerns more than a third of the triangles; such a mesh should be remeshed as a whole.
std::optional<Mesh> regraded(const Mesh& mesh, const Mesh& surface, const SizingField& field);

} // namespace anatomy
