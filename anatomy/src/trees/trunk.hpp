// The part of a lumen in which a ball of an aorta's size fits, and the vessels that arise from it.
#pragma once
#include "centreline/ball_path.hpp"
#include "core/wall_tree.hpp"
#include <optional>

namespace anatomy {

/// A connected part of the lumen outside the trunk: a vessel that leaves it.
struct Offshoot {
  BallPath path;                              ///< path from its farthest ball to the middle of the trunk
  double outside_length = 0;                  ///< mm along `path` to the trunk's surface: the length outside the trunk
  std::vector<std::pair<Vec3, double>> balls; ///< centre and radius (mm) of all its inscribed balls
};

/// The lumen's opening by a ball (mathematical morphology): the space of all balls larger than a given one that are
/// connected to the largest.
class Trunk {
public:
  /// The trunk of these inscribed balls; nothing if none has a radius above `least_radius` (mm). Balls that reach
  /// through the wall do not count. An example is the circumsphere of four points of one round rim: its position is a
  /// rounding error.
  static std::optional<Trunk> of(const Balls& balls, const WallTree& wall, double least_radius);

  double radius() const { return balls_.radius[largest_]; } ///< mm, of its largest ball
  Vec3 centre() const { return balls_.centre[largest_]; }
  /// Whether p (mm) lies inside one of the trunk's balls.
  bool contains(const Vec3& p) const { return distance_outside(p) < 0; }
  /// Distance (mm) from p to the nearest surface of the trunk's balls; negative inside a ball.
  double distance_outside(const Vec3& p) const;
  /// Centre of the largest of the trunk's balls that contain p; centre of its largest ball if none contains p.
  Vec3 centre_near(const Vec3& p) const;
  /// Ball centres (mm) along the cheapest path from the trunk's largest ball to its ball nearest to p.
  std::vector<Vec3> path_to(const Vec3& p) const;
  /// The vessels that reach at least `least_length` (mm) out of the trunk, the longest first.
  std::vector<Offshoot> offshoots(double least_length) const;

private:
  Trunk(const Balls& balls, const WallTree& wall, std::size_t largest, double least_radius);

  Balls balls_;
  std::size_t largest_;
  ShortestPaths paths_; // from the largest ball
  std::vector<std::size_t> filling_balls_;
};

} // namespace anatomy
