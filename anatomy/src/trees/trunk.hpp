// The part of a lumen in which a ball of an aorta's size fits, and the vessels that arise from it.
#pragma once
#include "centreline/ball_way.hpp"
#include "core/wall_tree.hpp"
#include <optional>

namespace anatomy {

/// A connected part of the lumen outside the trunk: a vessel that leaves it.
struct Offshoot {
  BallWay way;                                ///< from its farthest ball to the middle of the trunk
  double from = 0;                            ///< mm along the way to the trunk: the vessel's length outside it
  std::vector<std::pair<Vec3, double>> balls; ///< centre and radius (mm) of all its balls
};

/// The lumen's opening by a ball (mathematical morphology): the space of all balls larger than a given one that are
/// connected to the largest.
class Trunk {
public:
  /// None if no ball is larger than `least_radius` (mm). Balls that reach through the wall do not count, such as a
  /// circumsphere of four points of one round rim, whose position is a rounding error.
  static std::optional<Trunk> of(const Balls& balls, const WallTree& wall, double least_radius);

  double radius() const { return balls_.radius[largest_]; } ///< mm, of its largest ball
  Vec3 centre() const { return balls_.centre[largest_]; }
  bool holds(const Vec3& p) const { return outside(p) < 0; }
  /// Distance (mm) from the nearest surface of its balls; negative inside.
  double outside(const Vec3& p) const;
  /// Centre of the largest of its balls that contain p; of its largest ball if none does.
  Vec3 middle_near(const Vec3& p) const;
  /// The centres of its balls on the cheapest way from its largest ball to the ball nearest to p.
  std::vector<Vec3> way_to(const Vec3& p) const;
  /// The offshoots that reach at least `least_length` (mm) out of the trunk, the longest first.
  std::vector<Offshoot> offshoots(double least_length) const;

private:
  Trunk(const Balls& balls, const WallTree& wall, std::size_t largest, double least_radius);

  Balls balls_;
  std::size_t largest_;
  Ways ways_; // from the largest ball
  std::vector<std::size_t> filling_;
};

} // namespace anatomy
