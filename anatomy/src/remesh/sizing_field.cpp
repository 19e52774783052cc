#include "remesh/sizing_field.hpp"
#include <algorithm>

namespace anatomy {
namespace {

constexpr double edge_per_radius = 0.3;         // longest edge, in inscribed radii
constexpr double largest_edge_per_radius = 0.8; // the same limit in the narrowest throats: eight edges go round them
constexpr double least_throat_edge = 0.05;      // mm, least edge in a throat, unless 0.3 of the user's edge is shorter
constexpr double edge_growth = 0.3;             // mm of edge per mm of distance from a narrow place

} // namespace

SizingField::SizingField(double edge, const std::vector<Branch>& branches,
                         const std::vector<ReferenceProfile>& profiles)
    : edge_(edge) {
  for (std::size_t b = 0; b < branches.size(); ++b)
    for (std::size_t i = 0; i < branches[b].x.size(); ++i) {
      if (branches[b].s[i] < branches[b].s_outside)
        continue;
      const double radius = branches[b].radius[i], reference = 0.5 * profiles[b].diameter(branches[b].s[i]);
      const double wanted = std::min(edge * radius / reference, edge_per_radius * radius);
      const double least =
          std::min(smallest_edge_factor * edge, std::max(largest_edge_per_radius * radius, least_throat_edge));
      if (wanted < edge)
        narrow_samples_.push_back({branches[b].x[i], radius, std::max(wanted, least)});
    }
}

double SizingField::at(const Vec3& p) const {
  double length = edge_;
  for (const NarrowSample& sample : narrow_samples_)
    length = std::min(length, sample.edge + edge_growth * std::max(0.0, (p - sample.x).norm() - sample.radius));
  return length;
}

} // namespace anatomy
