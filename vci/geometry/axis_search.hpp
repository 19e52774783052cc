// The place on a branch's axis that is nearest to a point.
#pragma once
#include "vci/geometry/centreline.hpp"

namespace vci {

struct AxisPlace {
  Vec3 point = Vec3::Zero();
  double s = 0; ///< arc length, mm
};

/// A branch's axis as pieces of a polyline, in groups within spheres. It ends where the path's points do.
class AxisSearch {
public:
  explicit AxisSearch(const Path& path);
  /// The search begins where the last one ended, because neighbours in a file are mostly neighbours in space.
  AxisPlace nearest(const Vec3& p);

private:
  static constexpr std::size_t group = 16;
  struct Group {
    std::size_t first, last;
    Vec3 centre;
    double radius;
  };
  Vectors points_;
  std::vector<double> s_;
  std::vector<Group> groups_;
  std::size_t last_ = 0;
};

} // namespace vci
