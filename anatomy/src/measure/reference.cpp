#include "measure/reference.hpp"
#include "measure/reference_lines.hpp"
#include <array>

namespace anatomy {
namespace {

// Exponents m of the law of forks D^m = d1^m + d2^m that are tried besides 2.55 (Murray 1926; Huo and Kassab 2012).
constexpr std::array<double, 2> other_exponents{3, 7.0 / 3};
constexpr double least_gain_ratio = 1.25; // another profile needs this many times as many healthy sections
constexpr double ectasia_ratio = 1.5;     // least ratio to the widest lumen beside it (definition of coronary ectasia)
// Largest ratio of neighbouring samples' diameters on the flank of an ectasia. The steepest taper changes less: 0.75 %
// of the first diameter.
constexpr double ectasia_flank_ratio = 0.99;
constexpr double other_reading_ratio = 1.05; // another line is reported if its diameter differs by this ratio
constexpr double least_noticed_branch = 0.4; // as a share of the widest section; smaller branches make a step below 4 %
// No stretch is healthy if the best profile has fewer than 8 healthy sections (4 mm), and fewer than this share of all.
constexpr double least_healthy_share = 0.25;

// The sections without an ectasia and its flanks. An ectasia is a single stretch with at least 8 sections before and
// behind it. Its widest section is more than 1.5 times as wide as any section before or behind it.
std::vector<DiameterSample> without_ectasia(std::vector<DiameterSample> measured, const Branch& branch,
                                            std::vector<Repair>& notes) {
  const std::size_t all = measured.size();
  DiameterSample widest{};
  while (std::ssize(measured) > 2 * fewest_sections) {
    const DiameterSample peak = *std::max_element(measured.begin(), measured.end(), is_less_wide);
    const auto wide = [&](const DiameterSample& c) { return c.diameter >= peak.diameter / ectasia_ratio; };
    const auto first = std::find_if(measured.begin(), measured.end(), wide);
    const auto last = std::find_if(measured.rbegin(), measured.rend(), wide).base();
    if (first - measured.begin() < fewest_sections || measured.end() - last < fewest_sections ||
        !std::all_of(first, last, wide))
      break;
    if (measured.size() == all)
      widest = peak;
    auto from = first, to = last;
    while (from != measured.begin() && (from - 1)->diameter < ectasia_flank_ratio * from->diameter)
      --from;
    while (to != measured.end() && to->diameter < ectasia_flank_ratio * (to - 1)->diameter)
      ++to;
    measured.erase(from, to);
  }
  if (measured.size() < all) {
    char detail[192];
    std::snprintf(detail, sizeof detail, "%s about %.1f mm along it: up to %.2f mm wide", branch.name.c_str(), widest.s,
                  widest.diameter);
    notes.push_back({"ectasia left out of the reference", 1, detail, true});
  }
  return measured;
}

void note_irregular(const std::vector<DiameterSample>& measured, const Branch& branch, const ReferenceProfile& profile,
                    std::vector<Repair>& notes) {
  const double from = measured.front().s, to = measured.back().s;
  char detail[256];
  std::snprintf(detail, sizeof detail,
                "%s: less than %.0f mm of it follow one line within %.0f %%. A quarter of it is wider than the "
                "reference, %.2f mm at %.1f mm and %.2f mm at %.1f mm",
                branch.name.c_str(), fewest_sections * sample_spacing, 100 * healthy_tolerance, profile.diameter(from),
                from, profile.diameter(to), to);
  notes.push_back({"no healthy stretch for the reference", 1, detail, true});
}

void note_dilatation(const ProfileChoice& choice, const std::vector<DiameterSample>& measured, const Branch& branch,
                     const ReferenceProfile& profile, std::vector<Repair>& notes) {
  const auto first = measured.begin() + static_cast<long>(choice.dilated);
  const auto last = measured.begin() + static_cast<long>(choice.narrower) - 1;
  const auto widest = std::max_element(first, last + 1, is_less_wide);
  char detail[192];
  std::snprintf(detail, sizeof detail, "%s from %.1f to %.1f mm along it: up to %.2f mm wide, %.2f mm beside it",
                branch.name.c_str(), first->s, last->s, widest->diameter, profile.diameter(first->s));
  notes.push_back({"dilatation left out of the reference", 1, detail, true});
}

void note_step(const ProfileChoice& choice, const std::vector<DiameterSample>& measured, const Branch& branch,
               const ReferenceProfile& profile, const SideBranches& branches, std::vector<Repair>& notes) {
  const double from = profile.step->from, to = profile.step->to;
  const double before = profile.diameter(measured[choice.last - 1].s), behind = profile.diameter(to);
  if (behind > (1 - 2 * healthy_tolerance) * before || branch_diameter_at_step(branches, from, to, before) > 0)
    return;
  char detail[256];
  std::snprintf(
      detail, sizeof detail,
      "%s %.1f mm along it: from %.2f to %.2f mm. It is read as a branch that the surface leaves out; it may be a "
      "narrowing up to the end",
      branch.name.c_str(), from, before, behind);
  notes.push_back({"reference steps down where no branch leaves", 1, detail, true});
}

// Warns if another line of healthy diameters fits the vessel, too: at least twice as many sections lie on it as on the
// chosen profile, and at least half of all sections. It was not chosen since too many sections are wider than it.
void note_other_reading(const std::vector<LineCandidate>& lines, double healthy,
                        const std::vector<DiameterSample>& measured, const Branch& branch, const SideBranches& sides,
                        const ReferenceProfile& profile, std::vector<Repair>& notes) {
  const std::size_t n = measured.size();
  const LineCandidate& other =
      *std::max_element(lines.begin(), lines.end(), [n](const LineCandidate& a, const LineCandidate& b) {
        return a.healthy_between(0, n) < b.healthy_between(0, n);
      });
  const double most = other.healthy_between(0, n);
  if (most < 2 * healthy || 2 * most < static_cast<double>(n))
    return;
  // the section on the other line at which the two readings differ most
  double widest = other_reading_ratio, s = 0, narrower = 0;
  for (std::size_t i = 0; i < n; ++i)
    if (const double at = measured[i].s, by_other = diameter_behind_branches(other.line.at(at), sides, at);
        other.healthy_between(i, i + 1) > 0.5 && profile.diameter(at) > widest * by_other) {
      widest = profile.diameter(at) / by_other;
      s = at;
      narrower = by_other;
    }
  if (narrower == 0)
    return;
  const double share = 100.0 / static_cast<double>(n);
  char detail[256];
  std::snprintf(detail, sizeof detail,
                "%s: %.0f %% of it is healthy by the reference, %.2f mm at %.1f mm. Another reading takes %.0f %% for "
                "healthy: %.2f mm there",
                branch.name.c_str(), share * healthy, profile.diameter(s), s, share * most, narrower);
  notes.push_back({"reference by a short healthy part", 1, detail, true});
}

// The sets of side branches past which the reference may step down: all, none, all with another exponent, and all but
// one. The branch left out may bring blood, as a graft does, or carry no flow.
// @param widest diameter of the widest section, mm
std::vector<SideBranches> flow_splits_to_try(const SideBranches& sides, double widest) {
  std::vector<SideBranches> splits{sides};
  if (!sides.branches.empty())
    splits.push_back({});
  if (std::any_of(sides.branches.begin(), sides.branches.end(),
                  [&](const auto& side) { return side.second > least_noticed_branch * widest; }))
    for (double exponent : other_exponents)
      splits.push_back({sides.branches, exponent});
  for (std::size_t k = 0; sides.branches.size() > 1 && k < sides.branches.size(); ++k)
    if (sides.branches[k].second > least_noticed_branch * widest) {
      splits.push_back(sides);
      splits.back().branches.erase(splits.back().branches.begin() + static_cast<std::ptrdiff_t>(k));
    }
  return splits;
}

// Warns of a branch past which the reference does not step while it steps past others.
void note_skipped_branch(const SideBranches& sides, const SideBranches& branches, const Branch& branch,
                         const ReferenceProfile& profile, std::vector<Repair>& notes) {
  if (sides.branches.empty() || sides.branches.size() == branches.branches.size())
    return;
  const auto at = std::mismatch(sides.branches.begin(), sides.branches.end(), branches.branches.begin()).second;
  char detail[256];
  std::snprintf(detail, sizeof detail,
                "%s %.1f mm along it: a branch of %.2f mm leaves, and the reference is %.2f mm before and behind it. "
                "The branch may bring blood, as a graft does, or the vessel may be narrowed up to it",
                branch.name.c_str(), at->first, at->second, profile.diameter(at->first));
  notes.push_back({"reference does not step down past a branch", 1, detail, true});
}

// The profile with the best score, which is the number of healthy sections less that of sections that are too wide. Its
// diameter steps down past side branches as the flow splits. A profile without these steps is taken only if its score
// is larger by more than 8. Other profiles also need a quarter more healthy sections: one with a dilatation, with
// another exponent, without the step of one branch, or with a step of another size.
// @param stubs arc lengths of the closed stubs on this branch, mm
ReferenceProfile best_profile(const std::vector<DiameterSample>& measured, const Branch& branch,
                              const SideBranches& branches, const std::vector<double>& stubs,
                              std::vector<Repair>& notes) {
  const std::size_t n = measured.size();
  const std::vector<SideBranches> flow_splits =
      flow_splits_to_try(branches, std::max_element(measured.begin(), measured.end(), is_less_wide)->diameter);
  std::vector<std::vector<LineCandidate>> lines;
  for (const SideBranches& sides : flow_splits)
    lines.push_back(candidate_lines(measured, sides));
  ProfileChoice best;
  std::size_t split = 0;
  const std::size_t all_or_none = branches.branches.empty() ? 1 : 2; // number of flow_splits with all branches or none
  const auto whole = static_cast<std::size_t>( // number of flow_splits in which no single branch is left out
      std::count_if(flow_splits.begin(), flow_splits.end(), [&](const SideBranches& one) {
        return one.branches.empty() || one.branches.size() == branches.branches.size();
      }));
  const auto take_if_better = [&](const auto& choice, std::size_t splits) {
    const ProfileChoice before = best;
    for (std::size_t k = 0; k < splits; ++k)
      if (const ProfileChoice one = choice(k);
          one.score > best.score + (k > 0 ? fewest_sections : 0) && one.healthy >= least_gain_ratio * before.healthy) {
        best = one;
        split = k;
      }
  };
  take_if_better([&](std::size_t k) { return best_line(lines[k], 0, n); }, all_or_none);
  take_if_better([&](std::size_t k) { return best_line_beside_dilatation(lines[k]); }, all_or_none);
  take_if_better([&](std::size_t k) { return best_line(lines[k], 0, n); }, lines.size());
  take_if_better([&](std::size_t k) { return best_step(lines[k], measured, flow_splits[k], branches, stubs); }, whole);
  if (best.healthy < std::min<double>(fewest_sections, least_healthy_share * static_cast<double>(n))) {
    const ReferenceProfile profile{upper_quartile_line(lines.front(), measured, branches), branches};
    note_irregular(measured, branch, profile, notes);
    return profile;
  }
  const ReferenceProfile profile = fit_profile(best, measured, flow_splits[split]);
  if (best.behind)
    note_step(best, measured, branch, profile, branches, notes);
  else if (best.narrower > 0)
    note_dilatation(best, measured, branch, profile, notes);
  note_skipped_branch(flow_splits[split], branches, branch, profile, notes);
  note_other_reading(lines[split], best.healthy, measured, branch, flow_splits[split], profile, notes);
  return profile;
}

// The sections at a distance of about `sample_spacing`: some of those that lie closer, and values between those that
// lie further apart.
std::vector<DiameterSample> evenly_spaced(const std::vector<DiameterSample>& measured) {
  std::vector<DiameterSample> samples;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const DiameterSample& here = measured[i];
    if (samples.empty()) {
      samples.push_back(here);
      continue;
    }
    const DiameterSample before = samples.back();
    const double target = before.s + sample_spacing;
    if (i + 1 < measured.size() && std::abs(measured[i + 1].s - target) < std::abs(here.s - target))
      continue;
    const int steps = static_cast<int>(std::lround((here.s - before.s) / sample_spacing));
    for (int k = 1; k < steps; ++k) {
      const double share = static_cast<double>(k) / steps;
      samples.push_back({std::lerp(before.s, here.s, share), std::lerp(before.diameter, here.diameter, share),
                         before.in_mouth && here.in_mouth});
    }
    if (steps > 0)
      samples.push_back(here);
  }
  return samples;
}

// A constant profile: twice the median of the inscribed radii.
ReferenceProfile constant_profile(const Branch& branch) {
  std::vector<double> radius = branch.radius;
  std::nth_element(radius.begin(), radius.begin() + static_cast<long>(radius.size() / 2), radius.end());
  return {{2 * radius[radius.size() / 2], 0}, {}, {}};
}

} // namespace

double ReferenceProfile::diameter(double s) const {
  double healthy = line.at(s);
  if (step && s >= step->to)
    healthy = step->line.at(s);
  else if (step && s > step->from)
    healthy = std::lerp(line.at(step->from), step->line.at(step->to), (s - step->from) / (step->to - step->from));
  return diameter_behind_branches(healthy, sides, s);
}

std::vector<DiameterSample> diameter_samples(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                                             std::size_t branch) {
  std::vector<DiameterSample> out;
  for (const Section& section : sections)
    if (section.branch == branch && section.flag != SectionFlag::end)
      out.push_back(
          {branches[branch].s[section.sample], section.equivalent_diameter(), section.flag == SectionFlag::ostium});
  return out;
}

std::vector<ReferenceProfile> reference_profiles(const std::vector<Branch>& branches,
                                                 const std::vector<Section>& sections, std::vector<Repair>& notes,
                                                 const std::vector<ClosedStub>& stubs) {
  std::vector<ReferenceProfile> profiles(branches.size());
  // the deepest generation comes first, since a branch needs the reference diameters of its side branches
  std::vector<std::size_t> order(branches.size());
  const auto generation = [&](std::size_t b) {
    int n = 0;
    for (int parent = branches[b].parent; parent >= 0; parent = branches[static_cast<std::size_t>(parent)].parent)
      ++n;
    return n;
  };
  for (std::size_t b = 0; b < order.size(); ++b)
    order[b] = b;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return generation(a) > generation(b); });
  for (std::size_t b : order) {
    const std::vector<DiameterSample> measured =
        without_ectasia(evenly_spaced(diameter_samples(branches, sections, b)), branches[b], notes);
    if (std::ssize(measured) < fewest_sections) {
      profiles[b] = constant_profile(branches[b]);
      notes.push_back({"constant reference diameter", 1, branches[b].name + " is too short for a profile"});
      continue;
    }
    SideBranches sides;
    for (std::size_t k = 0; k < branches.size(); ++k)
      if (branches[k].parent == static_cast<int>(b))
        sides.branches.emplace_back(branches[k].s_on_parent, profiles[k].diameter(branches[k].s_outside));
    std::vector<double> stubs_here; // arc lengths, mm
    for (const ClosedStub& stub : stubs)
      if (stub.branch == b)
        stubs_here.push_back(stub.s);
    profiles[b] = best_profile(measured, branches[b], sides, stubs_here, notes);
  }
  return profiles;
}

} // namespace anatomy
