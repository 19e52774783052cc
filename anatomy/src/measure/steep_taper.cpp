#include "measure/steep_taper.hpp"

namespace anatomy {
namespace {

// The LAD loses half of its width (3.7 to 1.9 mm, Dodge 1992), .5 % per mm of the first diameter; other vessels less.
constexpr double usual = 0.5, steep = 1; // per cent per mm
constexpr double long_enough = 20;       // mm: a short stretch tapers as its few sections say

} // namespace

void note_steep_tapers(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                       const std::vector<ReferenceProfile>& profiles, std::vector<Repair>& notes) {
  for (std::size_t b = 0; b < branches.size(); ++b) {
    const std::vector<Calibre> measured = calibres(branches, sections, b);
    if (measured.empty())
      continue;
    const double from = measured.front().s, to = measured.back().s;
    const ReferenceLine& line = profiles[b].line;
    const double taper = -100 * line.slope / line.at(from);
    if (taper < steep || to - from < long_enough)
      continue;
    char detail[320];
    std::snprintf(
        detail, sizeof detail,
        "%s: its reference falls from %.2f to %.2f mm over %.0f mm, by %.1f %% per mm; an LAD tapers by %.1f "
        "%% per mm. Diffuse disease that narrows the vessel evenly looks the same, and counts as healthy here",
        branches[b].name.c_str(), line.at(from), line.at(to), to - from, taper, usual);
    notes.push_back({"reference tapers steeply", 1, detail, true});
  }
}

} // namespace anatomy
