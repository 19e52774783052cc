// Paths along the branches of the centreline, places on them, and how they follow the wall.
#pragma once
#include "vci/geometry/lumen.hpp"

namespace vci {

struct Frame {
  Vec3 origin, tangent, first, second; ///< first and second span the cross-section, carried without twist
};

/// A polyline with arc length; beyond its ends it goes on straight.
class Path {
public:
  Path() = default;
  /// @param start arc length of the first point (negative where a parent's axis comes before a side branch's).
  Path(Vectors points, double start);
  double start() const { return s_.front(); }
  double end() const { return s_.back(); }
  Vec3 at(double s) const;
  Vec3 tangent(double s) const; ///< unit; a chord over 1 mm
  /// Total turn of the path from s_start to s_end, rad. It is the sum of the angles between neighbouring pieces of
  /// about `piece_mm`, two at least, each with a fitted direction. Angles between short chords would sum up the scatter
  /// of the points. The angle between the two ends would miss bends that cancel. Half a piece at either end does not
  /// count.
  double turning(double s_start, double s_end, double piece_mm) const;
  std::vector<Frame> frames(const std::vector<double>& s) const;
  const Vectors& points() const { return points_; }

private:
  std::size_t piece(double s) const;
  Vec3 fitted_direction(double s_start, double s_end) const;
  Vectors points_;
  std::vector<double> s_;
};

/// The path moved by the mean displacement of the wall round it: of the points that lay within 0.5 mm along the axis
/// and within 1.5 local radii of it. Its arc lengths stay those of the reference, as labels.
Path follow_wall(const Path& path, const Lumen& lumen, const Vectors& moved);

} // namespace vci
