#include "measure/fused_vessels.hpp"

namespace anatomy {
namespace {

constexpr double fused_width_ratio = 1.15; // least ratio of a section's equivalent diameter to the reference
constexpr double fused_flatness = 1.8; // least ratio of longest to shortest chord; slit lesions are as flat, but narrow
constexpr double least_fused_length = 3.0; // mm, least length of a stretch of such sections

double largest_flatness(const std::vector<const Section*>& stretch) {
  double most = 0;
  for (const Section* section : stretch)
    most = std::max(most, section->max_diameter / section->min_diameter);
  return most;
}

} // namespace

void note_fused_vessels(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                        const std::vector<ReferenceProfile>& profiles, std::vector<Repair>& notes) {
  for (std::size_t b = 0; b < branches.size(); ++b) {
    std::vector<const Section*> stretch;
    const auto s_of = [&](const Section* section) { return branches[b].s[section->sample]; };
    const auto close = [&] {
      if (!stretch.empty() && s_of(stretch.back()) - s_of(stretch.front()) >= least_fused_length) {
        const Section& middle = *stretch[stretch.size() / 2];
        char detail[320];
        std::snprintf(
            detail, sizeof detail,
            "%s from %.1f to %.1f mm along it: sections up to %.1f times as long as wide, such as %.1f x %.1f "
            "mm, and wider than the reference of %.2f mm. A lesion there is not seen; separate the vessels",
            branches[b].name.c_str(), s_of(stretch.front()), s_of(stretch.back()), largest_flatness(stretch),
            middle.max_diameter, middle.min_diameter, profiles[b].diameter(s_of(&middle)));
        notes.push_back({"another vessel may be fused to the lumen", 1, detail, true});
      }
      stretch.clear();
    };
    for (const Section& section : sections) {
      if (section.branch != b)
        continue;
      const bool fused = section.flag == SectionFlag::ok &&
                         section.max_diameter > fused_flatness * section.min_diameter &&
                         section.equivalent_diameter() > fused_width_ratio * profiles[b].diameter(s_of(&section));
      if (fused)
        stretch.push_back(&section);
      else
        close();
    }
    close();
  }
}

} // namespace anatomy
