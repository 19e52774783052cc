// Paths along the branches of the centreline, places on them, and how they follow the wall.
#pragma once
#include "vci/geometry/lumen.hpp"

namespace vci {

struct Frame {
  Vec3 origin, tangent, first, second; ///< first and second span the cross-section and do not twist along the path
};

/// A polyline with arc length, extended straight beyond its ends.
class Path {
public:
  Path() = default;
  /// @param start arc length of the first point (negative if a parent's axis precedes a side branch's).
  Path(Vectors points, double start);
  double start() const { return s_.front(); }
  double end() const { return s_.back(); }
  Vec3 at(double s) const;
  Vec3 tangent(double s) const; ///< unit vector along a chord of 1 mm
  /// Total turn of the path from s_start to s_end, rad. It is the sum of the angles between the fitted directions of
  /// neighbouring pieces, at least two, of about `piece_mm`. Short chords would add up the scatter of the points. The
  /// angle between the two ends would miss bends that cancel. Bends within half a piece of either end are not counted.
  double turning(double s_start, double s_end, double piece_mm) const;
  std::vector<Frame> frames(const std::vector<double>& s) const;
  const Vectors& points() const { return points_; }

private:
  std::size_t piece(double s) const;
  Vec3 fitted_direction(double s_start, double s_end) const;
  Vectors points_;
  std::vector<double> s_;
};

/// The path moved by the mean displacement of the wall round it: of points within 0.5 mm along the axis and about 1.5
/// local radii. The arc lengths of the undeformed path are kept as labels.
Path follow_wall(const Path& path, const Lumen& lumen, const Vectors& moved);

} // namespace vci
