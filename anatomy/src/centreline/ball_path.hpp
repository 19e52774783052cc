// A path through the inscribed balls, and the direction of the vessel along it.
#pragma once
#include "centreline/inner_balls.hpp"

namespace anatomy {

/// The cheapest path from one ball back to the ball at which all `cheapest` paths start. Its points are the centres of
/// the balls, and `s` is the arc length along them.
struct BallPath {
  std::vector<std::size_t> balls; ///< indices of the balls on the path
  std::vector<Vec3> points;       ///< mm
  std::vector<double> radius, s;  ///< mm: each ball's radius, and its arc length from the first point

  BallPath() = default;
  BallPath(const Balls& balls, const ShortestPaths& cheapest, std::size_t ball);
  double length() const { return s.back(); }
  /// Index of the first point whose arc length is at least `where` (mm), or of the last point.
  std::size_t index_at(double where) const;
  /// Mean (mm) of the balls' centres within a quarter of a radius of `where` (mm), since single centres scatter about
  /// the axis.
  Vec3 centre(double where) const;
};

/// Unit direction of the vessel at `where` (mm) on the path. It is the direction most nearly perpendicular to the
/// wall's normals round that place. The path's own direction would scatter by more than a degree, since the balls'
/// centres scatter. So the path's direction is used only where the two differ by more than 30 degrees, for example
/// where a side branch leaves.
Vec3 vessel_direction(const Mesh& mesh, const BallPath& path, double where);

} // namespace anatomy
