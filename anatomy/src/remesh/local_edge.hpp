// Makes edges shorter where the vessel is narrow. A throat gets as many edges round it as the healthy vessel, and a
// thin branch enough to keep its area.
#pragma once
#include "core/wall_tree.hpp"
#include "measure/lesions.hpp"
#include <optional>

namespace anatomy {

constexpr double smallest_edge_factor = 0.3; ///< least share of the user's edge, except in very narrow throats

/// The edge length wanted at a place of the wall.
class EdgeField {
public:
  /// Round each sample of the axes the wanted edge is `edge` (mm) times R / R_reference. R is the inscribed radius and
  /// R_reference the healthy radius. The limits are:
  /// - at most 0.3 R, since a tube of chords e loses (e/R)^2 / 6 of its area;
  /// - at least smallest_edge_factor times `edge`;
  /// - in a throat so narrow that fewer than eight such edges would go round it: 0.8 R, but at least 0.05 mm.
  /// Outside the sample's inscribed sphere the wanted edge grows by 0.3 mm per mm, so that neighbouring triangles are
  /// alike.
  EdgeField(double edge, const std::vector<Branch>& branches, const std::vector<ReferenceProfile>& profiles);
  double at(const Vec3& p) const; ///< mm, at most `edge`
  double edge() const { return edge_; }

private:
  struct NarrowSample { // mm
    Vec3 x;
    double radius, edge;
  };
  double edge_;
  std::vector<NarrowSample> narrow_samples_; ///< samples whose edge is below edge_
};

/// A copy of the tagged `mesh` with the edges that `field` asks for. In `mesh` all edges are about as long as
/// field.edge(). Where `field` asks for shorter ones, the wall is remeshed in steps that shorten the edges by a factor
/// of 0.85. Corners are then widened to 30 degrees. Vertices are projected on the wall of `surface`, the smooth surface
/// that `mesh` was made from. Caps, rims and the wall's triangles at the rims stay. Throws ComputationError if the
/// result crosses itself or is not closed.
Mesh graded(const Mesh& mesh, const Mesh& surface, const EdgeField& field);

/// Does the same as graded() for a `mesh` with uniform edges of `edge` mm, shorter than field.edge(), as a narrow
/// throat needs them. Where `field` allows longer edges, the wall is remeshed to them in the same steps.
Mesh coarsened(const Mesh& mesh, double edge, const Mesh& surface, const EdgeField& field);

/// Does the same as graded() for a mesh that was graded before and deformed since. The mesh is remeshed only where
/// edges are no longer 0.5 to 1.6 times the wanted length or corners are below 30 degrees, and next to these places.
/// Returns nothing if this concerns more than a third of the triangles; such a mesh should be remeshed as a whole.
std::optional<Mesh> regraded(const Mesh& mesh, const Mesh& surface, const EdgeField& field);

} // namespace anatomy
