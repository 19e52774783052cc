#include "vci/procedure/stent_history.hpp"

#include <algorithm>
#include <numeric>

namespace vci {

namespace {

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// For each ring of a stent, whether at least half of its vertices are in contact with a balloon.
std::vector<char> filled_rings(const Stent& stent, const Body& body, const std::vector<ContactPoint>& contacts) {
  std::vector<char> in_contact(body.count, 0);
  for (const ContactPoint& p : contacts)
    for (int k = 0; k < 4; ++k) {
      const int v = p.stencil.vertex[k] - body.first;
      if (v >= 0 && v < body.count && p.force * std::abs(p.stencil.weight[k]) > 0)
        in_contact[v] = 1;
    }
  std::vector<char> filled;
  for (int r = 0; r < stent.grid.rings(); ++r) {
    const auto first = in_contact.begin() + r * stent.grid.ring_size;
    filled.push_back(2 * std::count(first, first + stent.grid.ring_size, 1) >= stent.grid.ring_size);
  }
  return filled;
}

} // namespace

double StentHistory::inflated_diameter() const {
  return 2 * mean(inflated_radii);
}

void record_inflation(StentHistory& h, const System& system, const std::vector<ContactPoint>& balloons) {
  const std::vector<double> radii = ring_radii(system, h.stent.body, h.stent.grid);
  if (h.inflated_radii.empty()) {
    h.inflated_radii = radii;
    return;
  }
  const std::vector<char> filled = filled_rings(h.stent, system.body(h.stent.body), balloons);
  for (std::size_t r = 0; r < radii.size(); ++r)
    if (filled[r])
      h.inflated_radii[r] = radii[r];
}

void record_extraction(StentHistory& h, const System& system) {
  h.final_diameter = 2 * mean(ring_radii(system, h.stent.body, h.stent.grid));
  const std::vector<double> sections = ring_section_areas(system, h.stent.body, h.stent.grid);
  h.minimal_area = *std::min_element(sections.begin(), sections.end());
  const Vectors centres = ring_centres(system, h.stent.body, h.stent.grid);
  h.first_end = centres.front();
  h.last_end = centres.back();
  h.final_length = 0;
  for (std::size_t k = 1; k < centres.size(); ++k)
    h.final_length += (centres[k] - centres[k - 1]).norm();
}

} // namespace vci
