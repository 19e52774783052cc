// Shorter edges where the vessel is narrow: a throat gets as many edges round it as the healthy vessel, a thin branch
// enough to keep its area.
#pragma once
#include "core/wall_tree.hpp"
#include "measure/lesions.hpp"
#include <optional>

namespace anatomy {

constexpr double smallest_edge_factor = 0.3;

/// The edge length wanted at a place of the wall.
class EdgeField {
public:
  /// Round each sample of the axes, `edge` (mm) times R / R_reference, and at most 0.3 R: a tube of chords e loses
  /// (e/R)^2 / 6 of its area. Never below smallest_edge_factor of `edge`, nor
  /// 0.8 R (but 0.05 mm) in a throat so narrow that fewer than eight of those would go round it. With distance from
  /// there it grows by 0.3 mm for each mm, so that neighbouring triangles are alike.
  EdgeField(double edge, const std::vector<Branch>& branches, const std::vector<ReferenceProfile>& profiles);
  double at(const Vec3& p) const; ///< mm, at most `edge`
  double edge() const { return edge_; }

private:
  struct Narrow {
    Vec3 x;
    double radius, edge;
  };
  double edge_;
  std::vector<Narrow> narrow_; ///< samples whose edge is below edge_
};

/// A copy of the tagged `mesh` of uniform edge field.edge() whose wall is remeshed, in nested steps of 0.85, to the
/// lengths of `field` where they are shorter; corners are then widened to 30 degrees. Vertices are projected on the
/// wall of `surface`, the smooth one that `mesh` was made from; caps, rims and the wall's triangles at the rims stay.
/// Throws ComputationError as remeshed().
Mesh graded(const Mesh& mesh, const Mesh& surface, const EdgeField& field);

/// Likewise of a `mesh` of a uniform shorter `edge` (mm), as a narrow throat needs: made coarser, in nested steps,
/// where `field` allows it.
Mesh coarsened(const Mesh& mesh, double edge, const Mesh& surface, const EdgeField& field);

/// Likewise of a mesh that was graded before and deformed since: only where its edges are no more 0.5 to 1.6 times as
/// long as wanted, where corners are below 30 degrees, and next to that; the rest is kept as it is. Nothing is returned
/// where more than a third of the triangles are to be remeshed: that is another mesh, to be remeshed as a whole.
std::optional<Mesh> regraded(const Mesh& mesh, const Mesh& surface, const EdgeField& field);

} // namespace anatomy
