// The place on a branch's axis that is nearest to a point.
#pragma once
#include "vci/geometry/centreline.hpp"

namespace vci {

struct AxisPoint {
  Vec3 point = Vec3::Zero();
  double s = 0; ///< arc length, mm
};

/// Finds the nearest place on the axis of a branch, a polyline. Consecutive pieces form groups with bounding spheres,
/// so that far groups are skipped. The axis is not extended beyond the path's points.
class AxisSearch {
public:
  explicit AxisSearch(const Path& path);
  /// The search begins in the group where the last search ended, because consecutive points mostly lie near each other.
  AxisPoint nearest(const Vec3& p);

private:
  static constexpr std::size_t group_size = 16; ///< largest number of pieces in a group
  struct Group {
    std::size_t first, last;
    Vec3 centre;
    double radius;
  };
  Vectors points_;
  std::vector<double> s_;
  std::vector<Group> groups_;
  std::size_t last_group_ = 0;
};

} // namespace vci
