#include "measure/steep_taper.hpp"
#include <algorithm>

namespace anatomy {
namespace {

// The LAD narrows from 3.7 to 1.9 mm over 100 mm (Dodge 1992), by 0.5 % of its first diameter per mm. Small branches
// narrow by as many mm per mm, which is a larger share of their diameter.
constexpr double lad_taper = 0.5,
                 least_steep_taper = 1;     // taper of the LAD, and least taper for a warning: per cent per mm
constexpr double least_steep_slope = 0.037; // least taper for a warning, mm per mm: twice the LAD's
constexpr double least_taper_length = 15;   // mm: in a shorter stretch a few sections decide the taper
constexpr double fork_offset = 0.01;        // mm; diameters are taken this far from a fork, beside the reference's step

// Arc lengths (mm) that divide a branch into stretches of constant taper, in order: `from`, `to`, and between them the
// forks and both ends of the reference's step. At forks and over the step the reference may step down.
std::vector<double> stretch_bounds(const std::vector<Branch>& branches, std::size_t b, const ReferenceProfile& profile,
                                   double from, double to) {
  std::vector<double> bounds{from, to};
  for (const Branch& side : branches)
    if (side.parent == static_cast<int>(b))
      bounds.push_back(side.s_on_parent);
  if (profile.step)
    bounds.insert(bounds.end(), {profile.step->from, profile.step->to});
  std::erase_if(bounds, [&](double s) { return s < from || s > to; });
  std::sort(bounds.begin(), bounds.end());
  return bounds;
}

} // namespace

void note_steep_tapers(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                       const std::vector<ReferenceProfile>& profiles, std::vector<Repair>& notes) {
  for (std::size_t b = 0; b < branches.size(); ++b) {
    const std::vector<DiameterSample> measured = diameter_samples(branches, sections, b);
    if (measured.empty())
      continue;
    const std::vector<double> bounds = stretch_bounds(branches, b, profiles[b], measured.front().s, measured.back().s);
    for (std::size_t k = 1; k < bounds.size(); ++k) {
      const double from = bounds[k - 1], to = bounds[k];
      const double first = profiles[b].diameter(from + fork_offset), last = profiles[b].diameter(to - fork_offset);
      const double taper = 100 * (first - last) / first / std::max(to - from, fork_offset);
      if (to - from < least_taper_length || taper < least_steep_taper ||
          (first - last) / (to - from) < least_steep_slope)
        continue;
      char detail[320];
      std::snprintf(detail, sizeof detail,
                    "%s from %.0f to %.0f mm along it: its reference falls from %.2f to %.2f mm, by %.1f %% per mm; an "
                    "LAD tapers by %.1f %% per mm. Diffuse disease that narrows the vessel evenly looks the same, and "
                    "counts as healthy here",
                    branches[b].name.c_str(), from, to, first, last, taper, lad_taper);
      notes.push_back({"reference tapers steeply", 1, detail, true});
    }
  }
}

} // namespace anatomy
