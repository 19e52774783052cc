#include "measure/lesions.hpp"
#include <algorithm>
#include <limits>

namespace anatomy {
namespace {

constexpr double shortest = 1.0; // mm, least length of a lesion that is not severe
constexpr double severe = 50;    // per cent: noise does not halve a diameter, so such a lesion counts at any length
constexpr double alike = 0.03;   // relative difference up to which two sections count as equally narrow

using Part = std::vector<Calibre>;

// Diameter stenosis of a section against the reference, per cent.
double stenosis(const Calibre& sample, const ReferenceProfile& profile) {
  return 100 * (1 - sample.diameter / profile.diameter(sample.s));
}

// Index of the section at which a stretch splits into two narrowings, one before and one behind it; 0 if it does not
// split. Of all sections it has the least ratio of its own stenosis to that of the milder narrowing. This ratio is at
// most one half. Sections at a side branch's mouth do not count, as the mouth widens them.
std::size_t recovery(const Part& part, const ReferenceProfile& profile) {
  std::vector<double> lacking(part.size()), behind(part.size());
  for (std::size_t i = 0; i < part.size(); ++i)
    lacking[i] = stenosis(part[i], profile);
  double worst = 0;
  for (std::size_t i = part.size(); i-- > 0;)
    behind[i] = worst = std::max(worst, lacking[i]);
  std::size_t best = 0;
  double least = 1 - recovered;
  worst = 0;
  for (std::size_t i = 0; i < part.size(); ++i) {
    worst = std::max(worst, lacking[i]);
    const double lesser = std::min(worst, behind[i]);
    if (!part[i].mouth && lesser >= least_stenosis && lacking[i] <= least * lesser) {
      least = lacking[i] / lesser;
      best = i;
    }
  }
  return best;
}

std::vector<Part> narrowings(const Part& part, const ReferenceProfile& profile) {
  const std::size_t at = recovery(part, profile);
  if (at == 0)
    return {part};
  const auto cut = part.begin() + static_cast<std::ptrdiff_t>(at);
  std::vector<Part> found = narrowings({part.begin(), cut + 1}, profile);
  for (Part& other : narrowings({cut, part.end()}, profile))
    found.push_back(std::move(other));
  return found;
}

// Of the sections whose ratio of diameter to reference is within 3 % of the least one, that of the smallest diameter.
Calibre throat(const Part& part, const ReferenceProfile& profile) {
  const auto left = [&](const Calibre& c) { return c.diameter / profile.diameter(c.s); };
  const auto narrower = [&](const Calibre& a, const Calibre& b) { return left(a) < left(b); };
  const double least = left(*std::min_element(part.begin(), part.end(), narrower));
  Calibre best{0, std::numeric_limits<double>::max(), false};
  for (const Calibre& c : part)
    if (left(c) <= (1 + alike) * least && c.diameter < best.diameter)
      best = c;
  return best;
}

Lesion measured(const Part& part, const ReferenceProfile& profile, std::size_t branch) {
  const Calibre narrowest = throat(part, profile);
  Lesion lesion;
  lesion.branch = branch;
  lesion.s_start = part.front().s;
  lesion.s_mla = narrowest.s;
  lesion.s_end = part.back().s;
  lesion.mld = narrowest.diameter;
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
    Part part;
    const auto close = [&] {
      for (const Part& one : narrowings(part, profiles[b]))
        if (one.size() > 1) {
          const Lesion lesion = measured(one, profiles[b], b);
          const bool is_long = lesion.s_end - lesion.s_start >= shortest;
          if (lesion.diameter_stenosis >= (is_long ? least_stenosis : severe))
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
