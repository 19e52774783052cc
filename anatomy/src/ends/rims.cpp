#include "ends/rims.hpp"
#include <algorithm>

namespace anatomy {
namespace {

// Least ratio of the section's area to the end's for a rounded rim: a vessel that widens by 6 degrees on each side over
// half a radius.
constexpr double as_large = 1.1;
// Largest ratio of the area of a section further in to that of the plane chosen: a plane further in would gain little.
constexpr double settled = 1.05;
constexpr double further = 0.5;  // radii of the section, from a plane to the section further in
constexpr double step = 0.05;    // radii of the section, between planes that are tried
constexpr double deepest = 0.75; // radii of the section, from the end to the last plane that is tried

} // namespace

std::optional<Plane> plane_behind_rim(const Slices& slices, const PatchPlane& end, double section) {
  if (section < as_large * end.area)
    return std::nullopt;
  const double radius = std::sqrt(section / M_PI);
  const auto outline = [&](double depth) { return slices.outline({end.centre - depth * end.normal, end.normal}); };
  for (double depth = step * radius - end.lowest; depth < deepest * radius; depth += step * radius) {
    const Outline here = outline(depth);
    if (here.area > 0 && outline(depth + further * radius).area < settled * here.area)
      return Plane{end.centre - depth * end.normal, -end.normal,
                   std::max(radius, section_cover * here.reach / half_width)};
  }
  return std::nullopt;
}

} // namespace anatomy
