#include "ends/rims.hpp"
#include <algorithm>

namespace anatomy {
namespace {

// The rim counts as rounded if the section behind it is at least this many times as large as the end (`growth`). A
// vessel without a rounded rim would have to widen by 6 degrees on each side over half a radius.
constexpr double rounded_rim_growth = 1.1;
// A plane is deep enough if the section further in is less than this many times as large as the plane's own section. A
// deeper cut would then gain little.
constexpr double settled_growth = 1.05;
// A section this many times as large as one of its width and of the end's shape is no cross-section. In a tight bend a
// plane behind the end meets the vessel once more, where it comes back.
constexpr double longest_section = 1.5;
constexpr double comparison_radii = 0.5; // distance from a plane to the section further in, in radii of the section
constexpr double rim_step_radii = 0.05;  // distance between planes that are tried, in radii of the section
constexpr double deepest_radii = 0.75; // distance from the end to the last plane that is tried, in radii of the section

} // namespace

std::optional<Plane> plane_behind_rim(const Slices& slices, const PatchPlane& end) {
  const auto size_at = [&](double depth) { return slices.section_size({end.centre - depth * end.normal, end.normal}); };
  const SectionSize behind = size_at(comparison_radii * std::sqrt(end.area / pi));
  if (growth(end.size(), behind) < rounded_rim_growth)
    return std::nullopt;
  const double radius = 0.5 * behind.width;
  for (double depth = rim_step_radii * radius - end.lowest; depth < deepest_radii * radius;
       depth += rim_step_radii * radius) {
    const SectionSize here = size_at(depth);
    if (here.area > longest_section * area_if_alike(end.size(), here.width))
      return std::nullopt;
    if (here.area > 0 && growth(here, size_at(depth + comparison_radii * radius)) < settled_growth)
      return Plane{end.centre - depth * end.normal, -end.normal,
                   std::max(radius, section_cover * here.reach / square_half_width)};
  }
  return std::nullopt;
}

} // namespace anatomy
