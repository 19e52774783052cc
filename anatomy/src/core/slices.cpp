#include "core/slices.hpp"
#include <limits>

namespace anatomy {
namespace {

bool contains_origin(const std::vector<Vec2>& loop) {
  bool inside = false;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
    if ((a.y() > 0) != (b.y() > 0) && a.x() - a.y() * (b.x() - a.x()) / (b.y() - a.y()) > 0)
      inside = !inside;
  }
  return inside;
}

} // namespace

double signed_area(const std::vector<Vec2>& loop) {
  double area = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
    area += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  return area;
}

double least_extent(const std::vector<Vec2>& points) {
  if (points.empty())
    return 0;
  constexpr int directions = 72; // every 2.5 degrees
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < directions; ++k) {
    const Vec2 along(std::cos(k * pi / directions), std::sin(k * pi / directions));
    double low = points[0].dot(along), high = low;
    for (const Vec2& p : points) {
      low = std::min(low, p.dot(along));
      high = std::max(high, p.dot(along));
    }
    least = std::min(least, high - low);
  }
  return least;
}

double area_if_alike(const SectionSize& a, double width) {
  return std::max(pi / 4, a.area / (a.width * a.width)) * width * width;
}

double growth(const SectionSize& a, const SectionSize& b) {
  return std::min(b.area, area_if_alike(a, b.width)) / a.area;
}

Slices::Slices(const Mesh& mesh) : tree_(mesh.edges().begin(), mesh.edges().end(), mesh), slicer_(mesh, tree_) {}

std::vector<Vec3> Slices::loop_around(const PlaneFrame& frame) const {
  std::vector<std::vector<Point>> polylines;
  slicer_(Kernel::Plane_3(point(frame.origin), Vector(frame.normal.x(), frame.normal.y(), frame.normal.z())),
          std::back_inserter(polylines));
  std::vector<Vec3> best;
  double smallest = 1e300;
  for (const auto& polyline : polylines) {
    if (polyline.size() < 4 || polyline.front() != polyline.back())
      continue;
    std::vector<Vec3> loop;
    std::vector<Vec2> flat;
    for (std::size_t i = 0; i + 1 < polyline.size(); ++i) {
      loop.push_back(vec(polyline[i]));
      flat.push_back(frame.plane(loop.back()));
    }
    const double area = std::abs(signed_area(flat));
    if (contains_origin(flat) && area < smallest) {
      smallest = area;
      best = loop;
    }
  }
  return best;
}

SectionSize Slices::section_size(const PlaneFrame& frame) const {
  SectionSize out;
  std::vector<Vec2> loop;
  for (const Vec3& p : loop_around(frame)) {
    loop.push_back(frame.plane(p));
    out.reach = std::max(out.reach, loop.back().norm());
  }
  out.area = std::abs(signed_area(loop));
  out.width = least_extent(loop);
  return out;
}

} // namespace anatomy
