// A path (way) through the inscribed balls, and the direction of the vessel along it.
#pragma once
#include "centreline/inner_balls.hpp"

namespace anatomy {

/// The cheapest way from `ball` back to the ball at which all `ways` start, by arc length.
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

/// Unit direction of the vessel at `where` on the way (mm). It is the direction most nearly perpendicular to the wall's
/// normals round the place, because the balls' centres scatter by more than a degree. If the normals disagree with the
/// way, because a side branch leaves there, it is the way's direction.
Vec3 direction_of(const Mesh& mesh, const BallWay& way, double where);

} // namespace anatomy
