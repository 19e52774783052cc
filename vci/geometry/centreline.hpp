// Paths along the branches of the centreline, places on them, and how they follow the wall.
#pragma once
#include "vci/geometry/lumen.hpp"

namespace vci {

/// A place on a path with three axes: the tangent, and two unit vectors that span the cross-section.
struct Frame {
  Vec3 origin, tangent, first, second; ///< mm for the origin; first and second do not twist along the path
};

/// A polyline whose places are given by arc length s (mm). It is extended straight beyond its ends.
class Path {
public:
  Path() = default;
  /// @param start arc length (mm) of the first point; negative if points of a parent branch precede a side branch
  Path(Vectors points, double start);
  double start() const { return s_.front(); }
  double end() const { return s_.back(); }
  Vec3 at(double s) const;
  Vec3 tangent(double s) const; ///< unit vector along the chord of 1 mm round s
  /// Total angle (rad) by which the path turns from s_start to s_end (mm). The path is divided into at least two pieces
  /// of about `piece_mm`, and a direction is fitted to each. The result is the sum of the angles between neighbouring
  /// directions. With short pieces the scatter of the points would add up. The angle between the directions at both
  /// ends would miss bends that cancel. Bends within half a piece of either end are not counted.
  double turning(double s_start, double s_end, double piece_mm) const;
  std::vector<Frame> frames(const std::vector<double>& s) const;
  const Vectors& points() const { return points_; }

private:
  std::size_t segment_index(double s) const;
  Vec3 fitted_direction(double s_start, double s_end) const;
  Vectors points_;
  std::vector<double> s_;
};

/// The path of a branch after the wall has moved. Each point moves by the weighted mean displacement of the wall points
/// near it: within 0.5 mm along the axis and about 1.5 local radii. The path is then smoothed. Arc lengths are measured
/// along the new path from the same start value.
/// @param current_points current positions of the lumen's points, mm
Path follow_wall(const Path& path, const Lumen& lumen, const Vectors& current_points);

} // namespace vci
