#include "measure/lesions.hpp"
#include <algorithm>
#include <limits>

namespace anatomy {
namespace {

constexpr double least_mild_length = 1.0; // mm, least length of a lesion that is not severe
constexpr double severe_stenosis =
    50; // per cent: noise does not halve a diameter, so such a lesion counts at any length
constexpr double equal_stenosis_share = 0.03; // relative difference up to which two sections count as equally narrow

using SectionRun = std::vector<DiameterSample>;

// Diameter stenosis of a section against the reference, per cent.
double stenosis(const DiameterSample& sample, const ReferenceProfile& profile) {
  return 100 * (1 - sample.diameter / profile.diameter(sample.s));
}

// Index of the section at which a stretch splits into two narrowings, one before and one behind it; 0 if it does not
// split. For each section, its stenosis is divided by the stenosis of the milder narrowing. The stretch splits where
// this ratio is least, if it is at most one half. Sections at a side branch's mouth do not count, as the mouth widens
// them.
std::size_t find_recovery(const SectionRun& run, const ReferenceProfile& profile) {
  std::vector<double> lacking(run.size()), behind(run.size());
  for (std::size_t i = 0; i < run.size(); ++i)
    lacking[i] = stenosis(run[i], profile);
  double worst = 0;
  for (std::size_t i = run.size(); i-- > 0;)
    behind[i] = worst = std::max(worst, lacking[i]);
  std::size_t best = 0;
  double least = 1 - split_recovery;
  worst = 0;
  for (std::size_t i = 0; i < run.size(); ++i) {
    worst = std::max(worst, lacking[i]);
    const double lesser = std::min(worst, behind[i]);
    if (!run[i].in_mouth && lesser >= least_stenosis && lacking[i] <= least * lesser) {
      least = lacking[i] / lesser;
      best = i;
    }
  }
  return best;
}

std::vector<SectionRun> narrowings(const SectionRun& run, const ReferenceProfile& profile) {
  const std::size_t at = find_recovery(run, profile);
  if (at == 0)
    return {run};
  const auto cut = run.begin() + static_cast<std::ptrdiff_t>(at);
  std::vector<SectionRun> found = narrowings({run.begin(), cut + 1}, profile);
  for (SectionRun& other : narrowings({cut, run.end()}, profile))
    found.push_back(std::move(other));
  return found;
}

// The section at which a lesion is measured. All sections whose ratio of diameter to reference is within 3 % of the
// least ratio count as equally narrow. Of these it has the smallest diameter.
DiameterSample throat(const SectionRun& run, const ReferenceProfile& profile) {
  const auto left = [&](const DiameterSample& c) { return c.diameter / profile.diameter(c.s); };
  const auto narrower = [&](const DiameterSample& a, const DiameterSample& b) { return left(a) < left(b); };
  const double least = left(*std::min_element(run.begin(), run.end(), narrower));
  DiameterSample best{0, std::numeric_limits<double>::max(), false};
  for (const DiameterSample& c : run)
    if (left(c) <= (1 + equal_stenosis_share) * least && c.diameter < best.diameter)
      best = c;
  return best;
}

Lesion measure_lesion(const SectionRun& run, const ReferenceProfile& profile, std::size_t branch) {
  const DiameterSample narrowest = throat(run, profile);
  Lesion lesion;
  lesion.branch = branch;
  lesion.s_start = run.front().s;
  lesion.s_mla = narrowest.s;
  lesion.s_end = run.back().s;
  lesion.mld = narrowest.diameter;
  lesion.mla = pi / 4 * lesion.mld * lesion.mld;
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
    SectionRun run;
    const auto close = [&] {
      for (const SectionRun& one : narrowings(run, profiles[b]))
        if (one.size() > 1) {
          const Lesion lesion = measure_lesion(one, profiles[b], b);
          const bool is_long = lesion.s_end - lesion.s_start >= least_mild_length;
          if (lesion.diameter_stenosis >= (is_long ? least_stenosis : severe_stenosis))
            lesions.push_back(lesion);
        }
      run.clear();
    };
    for (const DiameterSample& sample : diameter_samples(branches, sections, b))
      if (sample.diameter < (1 - shoulder_stenosis / 100) * profiles[b].diameter(sample.s))
        run.push_back(sample);
      else
        close();
    close();
  }
  std::stable_sort(lesions.begin(), lesions.end(),
                   [](const Lesion& a, const Lesion& b) { return a.diameter_stenosis > b.diameter_stenosis; });
  return lesions;
}

} // namespace anatomy
