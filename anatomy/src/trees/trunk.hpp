// The part of a lumen in which a sphere of an aorta's size fits, and the vessels that arise from it.
#pragma once
#include "centreline/sphere_path.hpp"
#include "core/wall_tree.hpp"
#include <optional>

namespace anatomy {

/// A connected part of the lumen outside the trunk: a vessel that leaves it.
struct Offshoot {
  SpherePath path;           ///< path from its farthest sphere to the middle of the trunk
  double outside_length = 0; ///< mm along `path` to the trunk's surface: the length outside the trunk
  std::vector<std::pair<Vec3, double>> spheres; ///< centre and radius (mm) of all its inscribed spheres
};

/// The lumen's opening by a ball (mathematical morphology): the space inside all inscribed spheres that are larger than
/// a given one and connected to the largest.
class Trunk {
public:
  /// The trunk of these inscribed spheres; nothing if none has a radius above `least_radius` (mm). Spheres that reach
  /// through the wall do not count. An example is the circumsphere of four points of one round rim: its position is a
  /// rounding error.
  static std::optional<Trunk> of(const InscribedSpheres& spheres, const WallTree& wall, double least_radius);

  double radius() const { return spheres_.radius[largest_]; } ///< mm, of its largest sphere
  Vec3 centre() const { return spheres_.centre[largest_]; }
  /// Whether p (mm) lies inside one of the trunk's spheres.
  bool contains(const Vec3& p) const { return distance_outside(p) < 0; }
  /// Distance (mm) from p to the nearest surface of the trunk's spheres; negative inside a sphere.
  double distance_outside(const Vec3& p) const;
  /// Centre of the largest of the trunk's spheres that contain p; centre of its largest sphere if none contains p.
  Vec3 centre_near(const Vec3& p) const;
  /// Sphere centres (mm) along the cheapest path from the trunk's largest sphere to its sphere nearest to p.
  std::vector<Vec3> path_to(const Vec3& p) const;
  /// The vessels that reach at least `least_length` (mm) out of the trunk, the longest first.
  std::vector<Offshoot> offshoots(double least_length) const;

private:
  Trunk(const InscribedSpheres& spheres, const WallTree& wall, std::size_t largest, double least_radius);

  InscribedSpheres spheres_;
  std::size_t largest_;
  ShortestPaths paths_; // from the largest sphere
  std::vector<std::size_t> filling_spheres_;
};

} // namespace anatomy
