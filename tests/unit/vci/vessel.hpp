// A tube along z with a narrowing at mid-length, and its centreline. Tests build their lumens from it.
#pragma once
#include "vci/geometry/centreline.hpp"
#include "vci/geometry/lumen.hpp"
#include "vci/geometry/surface.hpp"

#include <cmath>

namespace vci::tests {

struct Vessel {
  double length = 20, radius = 1.5, narrowing = 0.5,
         lesion_offset = 0; ///< in order: mm, mm, share of the radius, shift of the throat off the axis in mm
  int around = 16, rows = 48;

  double lesion_shape(double s) const { // 0 beside the lesion, 1 in its middle
    const double d = (s - length / 2) / 4;
    return std::abs(d) < 1 ? 0.5 * (1 + std::cos(pi * d)) : 0;
  }
  double radius_at(double s) const { return radius * (1 - narrowing * lesion_shape(s)); }
  Vec3 centre(double s) const { return {lesion_offset * lesion_shape(s), 0, s}; }

  Lumen lumen() const {
    Lumen l;
    for (int r = 0; r <= rows; ++r)
      for (int k = 0; k < around; ++k) {
        const double s = length * r / rows, angle = 2 * pi * (k + 0.5 * (r % 2)) / around, own = radius_at(s);
        l.points.push_back(centre(s) + Vec3(own * std::cos(angle), own * std::sin(angle), 0));
        l.radius.push_back(own);
      }
    for (int r = 0; r < rows; ++r)
      for (int k = 0; k < around; ++k) {
        const int a = r * around + k, b = r * around + (k + 1) % around, c = a + around, d = b + around;
        l.triangles.push_back({a, b, r % 2 == 0 ? c : d});
        l.triangles.push_back(r % 2 == 0 ? Triangle{b, d, c} : Triangle{a, d, c});
      }
    finish(l);
    return l;
  }

  /// The lumen with flat caps: region 1 at the inlet, region 2 at the outlet.
  Lumen closed() const {
    Lumen l = lumen();
    for (int end : {0, 1}) {
      const int middle = static_cast<int>(l.points.size()), first = end * rows * around;
      l.points.push_back(centre(end * length));
      l.radius.push_back(radius);
      for (int k = 0; k < around; ++k) {
        const int a = first + k, b = first + (k + 1) % around;
        l.triangles.push_back(end == 0 ? Triangle{b, a, middle} : Triangle{a, b, middle});
      }
    }
    finish(l);
    for (std::size_t k = l.triangles.size() - 2 * around; k < l.triangles.size(); ++k)
      l.region[k] = k < l.triangles.size() - around ? 1 : 2;
    return l;
  }

  Path axis(double start = 0, double end = -1) const {
    Vectors points;
    const double last = end < 0 ? length : end;
    for (int k = 0; k <= 80; ++k)
      points.push_back(centre(start + (last - start) * k / 80));
    return {points, start};
  }

private:
  static void finish(Lumen& l) {
    l.plaque.assign(l.points.size(), 0);
    l.plaque_type.assign(l.points.size(), 0);
    l.region.assign(l.triangles.size(), 0);
  }
};

} // namespace vci::tests
