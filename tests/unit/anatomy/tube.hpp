// Swept tubes with known axis and radius, as triangle soups.
#pragma once
#include "core/types.hpp"
#include <functional>
#include <random>

namespace anatomy::shapes {

struct Tube {
  std::function<Vec3(double)> axis;     ///< of arc length
  std::function<Vec3(double)> tangent;  ///< unit
  std::function<double(double)> radius; ///< of arc length
  double length = 20;
  double edge = 0.4;
  bool capped = true;
};

inline Tube straight(double radius, double length) {
  return {[](double s) { return Vec3(s, 0, 0); }, [](double) { return Vec3(1, 0, 0); }, [=](double) { return radius; },
          length};
}

/// A tube along an arc in the plane z = 0 with the curvature k.
inline Tube arc(double k, double radius, double length) {
  return {[=](double s) { return Vec3(std::sin(k * s) / k, (1 - std::cos(k * s)) / k, 0); },
          [=](double s) { return Vec3(std::cos(k * s), std::sin(k * s), 0); }, [=](double) { return radius; }, length};
}

/// Triangles that face outward. Successive rings of the wall are turned by half a step.
inline Soup soup_of(const Tube& tube) {
  Soup soup;
  const int rings = static_cast<int>(std::lround(tube.length / tube.edge));
  const int around = static_cast<int>(std::lround(2 * pi * tube.radius(0) / tube.edge));
  for (int i = 0; i <= rings; ++i) {
    const double s = tube.length * i / rings;
    const Vec3 t = tube.tangent(s), u = t.cross(Vec3(0, 0, 1)).normalized(), v = t.cross(u);
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * pi * (k + 0.5 * (i % 2)) / around;
      soup.points.push_back(point(tube.axis(s) + tube.radius(s) * (std::cos(angle) * u + std::sin(angle) * v)));
    }
  }
  const auto id = [&](int i, int k) { return static_cast<std::size_t>(i * around + (k + around) % around); };
  for (int i = 0; i < rings; ++i)
    for (int k = 0; k < around; ++k) {
      const int shift = i % 2;
      soup.triangles.push_back({id(i, k), id(i, k + 1), id(i + 1, k + shift)});
      soup.triangles.push_back({id(i + 1, k + shift), id(i, k + 1), id(i + 1, k + shift + 1)});
    }
  if (tube.capped)
    for (int i : {0, rings}) {
      const std::size_t centre = soup.points.size();
      soup.points.push_back(point(tube.axis(tube.length * i / rings)));
      for (int k = 0; k < around; ++k) {
        const Triangle t{centre, id(i, k + 1), id(i, k)};
        soup.triangles.push_back(i == 0 ? t : Triangle{t[0], t[2], t[1]});
      }
    }
  return soup;
}

inline bool reported(const std::vector<Repair>& repairs, const std::string& what) {
  for (const Repair& repair : repairs)
    if (repair.what == what)
      return true;
  return false;
}

} // namespace anatomy::shapes
