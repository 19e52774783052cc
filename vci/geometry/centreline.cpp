#include "vci/geometry/centreline.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace vci {

Path::Path(Vectors points, double start) : points_(std::move(points)) {
  s_.push_back(start);
  for (std::size_t k = 1; k < points_.size(); ++k)
    s_.push_back(s_.back() + (points_[k] - points_[k - 1]).norm());
}

std::size_t Path::segment_index(double s) const {
  const auto it = std::upper_bound(s_.begin() + 1, s_.end() - 1, s);
  return static_cast<std::size_t>(it - s_.begin());
}

Vec3 Path::at(double s) const {
  const std::size_t k = segment_index(s);
  const double t = (s - s_[k - 1]) / (s_[k] - s_[k - 1]);
  return (1 - t) * points_[k - 1] + t * points_[k];
}

Vec3 Path::tangent(double s) const {
  return (at(s + 0.5) - at(s - 0.5)).normalized();
}

/// Unit vector along the straight line that fits the path from s_start to s_end (mm) by least squares. The path is
/// sampled evenly by its arc length.
Vec3 Path::fitted_direction(double s_start, double s_end) const {
  constexpr int samples = 25;
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < samples; ++k)
    sum += (k - 0.5 * (samples - 1)) * at(s_start + (s_end - s_start) * k / (samples - 1));
  return sum.normalized();
}

double Path::turning(double s_start, double s_end, double piece_mm) const {
  const int count = std::max(2, static_cast<int>((s_end - s_start) / piece_mm));
  const double step = (s_end - s_start) / count;
  double sum = 0;
  Vec3 last = fitted_direction(s_start, s_start + step);
  for (int k = 1; k < count; ++k) {
    const Vec3 next = fitted_direction(s_start + k * step, s_start + (k + 1) * step);
    sum += std::atan2(last.cross(next).norm(), last.dot(next));
    last = next;
  }
  return sum;
}

std::vector<Frame> Path::frames(const std::vector<double>& s) const {
  std::vector<Frame> frames;
  for (double place : s) {
    Frame f{at(place), tangent(place), Vec3::Zero(), Vec3::Zero()};
    f.first = frames.empty() ? f.tangent.unitOrthogonal() : frames.back().first;
    f.first = (f.first - f.first.dot(f.tangent) * f.tangent).normalized();
    f.second = f.tangent.cross(f.first);
    frames.push_back(f);
  }
  return frames;
}

Path follow_wall(const Path& path, const Lumen& lumen, const Vectors& current_points) {
  Vectors shifted = path.points();
  for (std::size_t k = 0; k < shifted.size(); ++k) {
    const Vec3 centre = path.points()[k];
    const Vec3 along =
        (path.points()[std::min(k + 1, shifted.size() - 1)] - path.points()[k > 0 ? k - 1 : 0]).normalized();
    Vec3 sum = Vec3::Zero();
    double weight = 0;
    for (std::size_t v = 0; v < lumen.points.size(); ++v) {
      const Vec3 d = lumen.points[v] - centre;
      const double z = std::abs(d.dot(along));
      if (z < 0.5 && d.squaredNorm() < 2.25 * lumen.radius[v] * lumen.radius[v] + 0.25) {
        sum += (0.5 - z) * (current_points[v] - lumen.points[v]);
        weight += 0.5 - z;
      }
    }
    if (weight > 0)
      shifted[k] += sum / weight;
  }
  // Neighbouring points follow different sections of the wall, which leaves kinks. They are smoothed; the ends stay.
  for (int pass = 0; pass < 4; ++pass)
    for (std::size_t k = 1; k + 1 < shifted.size(); ++k)
      shifted[k] = 0.5 * shifted[k] + 0.25 * (shifted[k - 1] + shifted[k + 1]);
  return Path(shifted, path.start());
}

} // namespace vci
