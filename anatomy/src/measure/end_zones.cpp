#include "measure/end_zones.hpp"
#include <algorithm>

namespace anatomy {
namespace {

constexpr double wide_end_ratio = 1.1;    // least ratio of the diameter at an end to the reference that gives a warning
constexpr double near_end_radii = 2.5;    // a lesion nearer to an end than this (in reference radii) is beside the end
constexpr double least_end_stenosis = 20; // least diameter stenosis (per cent) at an end that gives a warning
// Percentage points by which the stenosis at an end must exceed the one in the next measured section.
constexpr double least_further_stenosis = 5;

struct WidestPlace {
  double s = 0, diameter = 0, ratio = 0;
};

// Of the inscribed spheres between two arc lengths (mm), the one with the largest ratio of diameter to reference.
WidestPlace widest_between(const Branch& branch, const ReferenceProfile& profile, double from, double to) {
  WidestPlace best;
  for (std::size_t i = 0; i < branch.s.size(); ++i) {
    const double s = branch.s[i], diameter = 2 * branch.radius[i], ratio = diameter / profile.diameter(s);
    if (s >= from && s <= to && ratio > best.ratio)
      best = {s, diameter, ratio};
  }
  return best;
}

// The section of branch number `b` nearest to arc length s (mm), which may lie in an end zone; null if there is none.
const Section* nearest_section(const Branch& branch, const std::vector<Section>& sections, std::size_t b, double s) {
  const Section* nearest = nullptr;
  for (const Section& one : sections)
    if (one.branch == b && (!nearest || std::abs(branch.s[one.sample] - s) < std::abs(branch.s[nearest->sample] - s)))
      nearest = &one;
  return nearest;
}

} // namespace

void note_wide_ends(const std::vector<Branch>& branches, const std::vector<ReferenceProfile>& profiles,
                    const std::vector<Lesion>& lesions, std::vector<Repair>& notes) {
  for (const Lesion& lesion : lesions) {
    const Branch& branch = branches[lesion.branch];
    const ReferenceProfile& profile = profiles[lesion.branch];
    const auto is_close = [&](double s, double end) {
      return std::abs(s - end) < near_end_radii * profile.diameter(s) / 2;
    };
    const auto note = [&](double from, double to) {
      const WidestPlace end = widest_between(branch, profile, from, to);
      if (end.ratio < wide_end_ratio)
        return;
      char detail[256];
      std::snprintf(
          detail, sizeof detail,
          "%s is %.2f mm wide %.1f mm along it, the reference there %.2f mm. A lesion of %.0f %% begins beside "
          "that end; by the end's width it is %.0f %%",
          branch.name.c_str(), end.diameter, end.s, end.diameter / end.ratio, lesion.diameter_stenosis,
          100 * (1 - lesion.mld / (lesion.reference * end.ratio)));
      notes.push_back({"end wider than the reference", 1, detail, true});
    };
    if (branch.parent < 0 && is_close(lesion.s_start, 0))
      note(0, lesion.s_start);
    if (is_close(lesion.s_end, branch.s.back()))
      note(lesion.s_end, branch.s.back());
  }
}

void note_narrow_ends(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                      const std::vector<ReferenceProfile>& profiles, std::vector<Repair>& notes) {
  for (std::size_t b = 0; b < branches.size(); ++b) {
    const Branch& branch = branches[b];
    const std::vector<DiameterSample> measured = diameter_samples(branches, sections, b);
    if (measured.empty())
      continue;
    const auto note = [&](const DiameterSample& next, double from, double to) {
      // The larger of two diameters counts. The inscribed sphere is too small where the axis is off the lumen's centre.
      // The section is too small where a slanted end cuts it.
      const auto stenosis = [&](double s) {
        const double by_sphere = next.diameter * branch.radius_at(s) / branch.radius_at(next.s);
        const Section* section = nearest_section(branch, sections, b, s);
        return 100 * (1 - std::max(by_sphere, section->equivalent_diameter()) / profiles[b].diameter(s));
      };
      double worst = 0, at = next.s;
      for (double s : branch.s)
        if (s >= from && s <= to && stenosis(s) > worst) {
          worst = stenosis(s);
          at = s;
        }
      if (worst < least_end_stenosis || worst < stenosis(next.s) + least_further_stenosis)
        return;
      char detail[256];
      std::snprintf(
          detail, sizeof detail,
          "%s is narrowed by about %.0f %% %.1f mm along it, so near its end that no section is measured. Its "
          "stenosis and smallest area are not in the results; give a longer lumen",
          branch.name.c_str(), worst, at);
      notes.push_back({"narrowing at an end", 1, detail, true});
    };
    if (branch.parent < 0)
      note(measured.front(), 0, measured.front().s);
    note(measured.back(), measured.back().s, branch.s.back());
  }
}

} // namespace anatomy
