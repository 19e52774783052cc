#include "lesions.hpp"
#include <algorithm>

namespace anatomy {
namespace {

constexpr double shortest = 1.0; // mm

Lesion measured(const std::vector<Calibre>& part, const ReferenceProfile& profile, std::size_t branch) {
  const auto narrowest = std::min_element(part.begin(), part.end(),
                                          [](const Calibre& a, const Calibre& b) { return a.diameter < b.diameter; });
  Lesion lesion;
  lesion.branch = branch;
  lesion.s_start = part.front().s;
  lesion.s_mla = narrowest->s;
  lesion.s_end = part.back().s;
  lesion.mld = narrowest->diameter;
  lesion.mla = M_PI / 4 * lesion.mld * lesion.mld;
  lesion.reference = profile.diameter(lesion.s_mla);
  lesion.proximal_reference = profile.diameter(lesion.s_start);
  lesion.distal_reference = profile.diameter(lesion.s_end);
  const double ratio = lesion.mld / lesion.reference;
  lesion.diameter_stenosis = 100 * (1 - ratio);
  lesion.area_stenosis = 100 * (1 - ratio * ratio);
  return lesion;
}

} // namespace

std::vector<Lesion> find_lesions(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                                 const std::vector<ReferenceProfile>& profiles) {
  std::vector<Lesion> lesions;
  for (std::size_t b = 0; b < branches.size(); ++b) {
    std::vector<Calibre> part;
    const auto close = [&] {
      if (part.size() > 1 && part.back().s - part.front().s >= shortest) {
        const Lesion lesion = measured(part, profiles[b], b);
        if (lesion.diameter_stenosis >= least_stenosis)
          lesions.push_back(lesion);
      }
      part.clear();
    };
    for (const Calibre& sample : calibres(branches, sections, b))
      if (sample.diameter < (1 - shoulder / 100) * profiles[b].diameter(sample.s))
        part.push_back(sample);
      else
        close();
    close();
  }
  std::stable_sort(lesions.begin(), lesions.end(),
                   [](const Lesion& a, const Lesion& b) { return a.diameter_stenosis > b.diameter_stenosis; });
  return lesions;
}

} // namespace anatomy
