#include "vci/geometry/axis_search.hpp"

#include <algorithm>

namespace vci {

AxisSearch::AxisSearch(const Path& path) : points_(path.points()), s_{path.start()} {
  for (std::size_t k = 1; k < points_.size(); ++k)
    s_.push_back(s_.back() + (points_[k] - points_[k - 1]).norm());
  for (std::size_t first = 0; first + 1 < points_.size(); first += group_size) {
    const std::size_t last = std::min(first + group_size, points_.size() - 1);
    const Vec3 centre = 0.5 * (points_[first] + points_[last]);
    double radius = 0;
    for (std::size_t k = first; k <= last; ++k)
      radius = std::max(radius, (points_[k] - centre).norm());
    groups_.push_back({first, last, centre, radius});
  }
}

AxisPoint AxisSearch::nearest(const Vec3& p) {
  AxisPoint best{points_.front(), s_.front()};
  double distance = 1e300;
  const auto search = [&](std::size_t g) {
    if ((p - groups_[g].centre).norm() - groups_[g].radius >= distance)
      return;
    for (std::size_t k = groups_[g].first; k < groups_[g].last; ++k) {
      const Vec3 along = points_[k + 1] - points_[k];
      const double t = std::clamp((p - points_[k]).dot(along) / along.squaredNorm(), 0.0, 1.0);
      const Vec3 q = points_[k] + t * along;
      if (const double d = (p - q).norm(); d < distance) {
        distance = d;
        best = {q, s_[k] + t * (s_[k + 1] - s_[k])};
        last_group_ = g;
      }
    }
  };
  search(last_group_);
  for (std::size_t g = 0; g < groups_.size(); ++g)
    search(g);
  return best;
}

} // namespace vci
