// The edge length that each place of the wall needs: a sizing field, as mesh generators call it. A throat gets as many
// edges round it as the healthy vessel, and a thin branch enough to keep its area.
#pragma once
#include "measure/reference.hpp"

namespace anatomy {

constexpr double smallest_edge_factor = 0.3; ///< least share of the user's edge, except in very narrow throats

/// The edge length wanted at a place of the wall.
class SizingField {
public:
  /// Round each sample of the axes the wanted edge is `edge` (mm) times R / R_reference. R is the inscribed radius and
  /// R_reference the healthy radius. The limits are:
  /// - at most 0.3 R, since a tube of chords e loses (e/R)^2 / 6 of its area;
  /// - at least smallest_edge_factor times `edge`;
  /// - in a throat so narrow that fewer than eight such edges would go round it: 0.8 R, but at least 0.05 mm.
  /// Outside the sample's inscribed sphere the wanted edge grows by 0.3 mm per mm, so that neighbouring triangles are
  /// alike.
  SizingField(double edge, const std::vector<Branch>& branches, const std::vector<ReferenceProfile>& profiles);
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

} // namespace anatomy
