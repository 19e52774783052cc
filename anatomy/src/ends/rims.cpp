#include "ends/rims.hpp"
#include <algorithm>

namespace anatomy {
namespace {

// Sizes are compared by the square of the width, the minor axis. It grows behind a rounded rim, which is narrower on
// all sides. It does not grow where a vessel bends or ends obliquely, and a section is longer for that reason alone.
// The rim counts as rounded if the squared width is at least this many times the end's. A vessel without a rounded rim
// would have to widen by 6 degrees on each side over half a radius.
constexpr double rounded_rim_ratio = 1.1;
// A plane is deep enough if the squared width further in is less than this many times its own. A deeper cut would then
// gain little.
constexpr double settled_ratio = 1.05;
constexpr double comparison_radii = 0.5; // distance from a plane to the section further in, in radii of the section
constexpr double rim_step_radii = 0.05;  // distance between planes that are tried, in radii of the section
constexpr double deepest_radii = 0.75; // distance from the end to the last plane that is tried, in radii of the section

double square(double x) {
  return x * x;
}

} // namespace

std::optional<Plane> plane_behind_rim(const Slices& slices, const PatchPlane& end) {
  const auto size_at = [&](double depth) { return slices.section_size({end.centre - depth * end.normal, end.normal}); };
  const double width = size_at(comparison_radii * std::sqrt(end.area / pi)).width;
  if (square(width) < rounded_rim_ratio * square(end.extent))
    return std::nullopt;
  const double radius = 0.5 * width;
  for (double depth = rim_step_radii * radius - end.lowest; depth < deepest_radii * radius;
       depth += rim_step_radii * radius) {
    const SectionSize here = size_at(depth);
    if (here.area > 0 && square(size_at(depth + comparison_radii * radius).width) < settled_ratio * square(here.width))
      return Plane{end.centre - depth * end.normal, -end.normal,
                   std::max(radius, section_cover * here.reach / square_half_width)};
  }
  return std::nullopt;
}

} // namespace anatomy
