// A way through the inscribed balls, and the direction of the vessel along it.
#pragma once
#include "centreline/inner_balls.hpp"

namespace anatomy {

/// A way through the balls by arc length, from `ball` to where the ways start.
struct BallWay {
  std::vector<std::size_t> balls;
  std::vector<Vec3> points;      ///< mm
  std::vector<double> radius, s; ///< mm

  BallWay() = default;
  BallWay(const Balls& balls, const Ways& ways, std::size_t ball);
  double length() const { return s.back(); }
  /// Index of the first point at or beyond `where` (mm), or of the last.
  std::size_t at(double where) const;
  /// Mean of the balls' centres within a quarter of a radius, since single ones scatter about the axis.
  Vec3 centre(double where) const;
};

/// Unit direction of the vessel at `where` on the way (mm), to which the wall's normals about the place are most nearly
/// perpendicular: the balls scatter too much to show it within a degree. Where these disagree with the way (a side
/// branch beside the place), the way decides.
Vec3 direction_of(const Mesh& mesh, const BallWay& way, double where);

} // namespace anatomy
