#include "measure/reference.hpp"
#include <algorithm>
#include <array>

namespace anatomy {
namespace {

// Exponents m of the law of forks D^m = d1^m + d2^m that are tried besides 2.55 (Murray 1926; Huo and Kassab 2012).
constexpr std::array<double, 2> other_exponents{3, 7.0 / 3};
// A section is healthy if it differs from the profile by less than this share of its diameter.
constexpr double healthy_tolerance = 0.03;
constexpr double wide_ratio = 1.08;      // a section is wide above this ratio to the profile; an ostium's may reach it
constexpr double ruled_out_score = -1e9; // score of a line that cannot be the reference
// Distance (mm) of the samples that a profile is fitted to. The numbers of sections below are then lengths, and the
// profile does not depend on the spacing of the sections.
constexpr double sample_spacing = 0.5;
constexpr int fewest_sections = 8;      // least number of samples (4 mm) for a profile, and for each of its parts
constexpr double upper_quantile = 0.75; // share of the sections below the reference of a vessel without healthy stretch
// Largest ratio of a reference to the widest section. A line through a healthy distal part rises above the proximal
// sections of a vessel that is narrowed there, but a diameter that the vessel has nowhere is not its healthy one.
constexpr double largest_extrapolation = 1.25;
// Lines are tried through pairs of at most so many sections.
constexpr std::size_t most_sampled_sections = 80;
constexpr double dilated_ratio = 1.15;    // a section is dilated above this ratio to the profile
constexpr double least_gain_ratio = 1.25; // another reading must have so many times as many healthy sections
// Least ratio of the diameter behind a step to the one before it. A fork into two equal branches has 0.737. A fork into
// branches of 0.6 and 0.87 has 0.6. Both follow from D = 0.678 (d1 + d2), Finet 2007.
constexpr double deepest_step = 0.737;         // where no stub and no wide branch is known
constexpr double deepest_step_by_branch = 0.6; // beside a closed stub or a wide branch
constexpr double split_tolerance = 0.1; // share by which a step at a branch may be deeper than the flow split says
constexpr double ectasia_ratio = 1.5;   // least ratio to the widest lumen beside it (definition of coronary ectasia)
// Largest ratio of neighbouring samples' diameters on the flank of an ectasia. The steepest taper changes less: 0.75 %
// of the first diameter.
constexpr double ectasia_flank_ratio = 0.99;
constexpr double least_trunk_share = 0.1; // share of D^m that is left behind side branches, however wide they are
// Largest taper of the reference, as a share of its first diameter per mm. An LAD tapers by 0.005 per mm (3.7 to 1.9 mm
// over 100 mm, Dodge 1992).
constexpr double steepest_taper = 0.015;
constexpr double other_reading_ratio = 1.05; // another reading is reported if its diameter differs by this ratio
constexpr double least_noticed_branch = 0.4; // as a share of the widest section; smaller branches make a step below 4 %

// Sum of d_k^m over the side branches that leave before s, in mm^m.
double branch_power_sum(const SideBranches& sides, double s) {
  double sum = 0;
  for (const auto& [at, diameter] : sides.branches)
    if (at < s)
      sum += std::pow(diameter, sides.exponent);
  return sum;
}

// The diameter (mm) at s behind the side branches. `line` (mm) is the diameter as if no branch had left before s.
double diameter_behind_branches(double line, const SideBranches& sides, double s) {
  if (sides.branches.empty())
    return line;
  const double trunk = std::pow(line, sides.exponent);
  return std::pow(std::max(trunk - branch_power_sum(sides, s), least_trunk_share * trunk), 1 / sides.exponent);
}

// The sections with the diameters that they would have if no side branch had left before them.
std::vector<DiameterSample> without_branch_steps(std::vector<DiameterSample> measured, const SideBranches& sides) {
  for (DiameterSample& c : measured)
    c.diameter = std::pow(std::pow(c.diameter, sides.exponent) + branch_power_sum(sides, c.s), 1 / sides.exponent);
  return measured;
}

bool is_less_wide(const DiameterSample& a, const DiameterSample& b) {
  return a.diameter < b.diameter;
}

// Weight of a section as healthy: 1 on the profile (mm), falling to 0 where its diameter differs by the share
// `healthy_tolerance`.
double healthy_weight(const DiameterSample& c, double profile) {
  const double off = (c.diameter - profile) / (healthy_tolerance * c.diameter);
  return std::max(0.0, 1 - off * off);
}

// A line, with running counts of the sections. Element k of each list is a count among the first k sections: `healthy`
// counts those on the line (sum of healthy_weight()), `wide` those above it, `dilated` those far above it.
struct LineCandidate {
  ReferenceLine line;
  std::vector<double> healthy{0};
  std::vector<int> wide{0}, dilated{0};

  double healthy_between(std::size_t a, std::size_t b) const { return healthy[b] - healthy[a]; }

  // The number of healthy sections from a to b, less the number of wide ones. The line is ruled out if 8 wide sections
  // in all lie before the first 8 healthy ones and behind the last 8. Then they are no bulge of a healthy vessel. They
  // are the healthy vessel, and the line follows a long narrowing.
  double score(std::size_t a, std::size_t b) const {
    const auto reached = [&](double count) {
      return static_cast<std::size_t>(std::lower_bound(healthy.begin(), healthy.end(), count) - healthy.begin());
    };
    const int before = wide[reached(std::min(healthy[a] + fewest_sections, healthy[b]))] - wide[a];
    const int behind = wide[b] - wide[std::max(a, reached(std::max(healthy[b] - fewest_sections, healthy[a])))];
    return before + behind < fewest_sections ? healthy_between(a, b) - (wide[b] - wide[a]) : ruled_out_score;
  }
};

// The lines that are tried: level lines, and lines through pairs of sections. The latter fall along the vessel, by no
// more than `steepest_taper`.
std::vector<LineCandidate> candidate_lines(const std::vector<DiameterSample>& measured, const SideBranches& sides) {
  const std::vector<DiameterSample> trunk = without_branch_steps(measured, sides);
  const double widest = std::max_element(trunk.begin(), trunk.end(), is_less_wide)->diameter;
  const std::size_t every = (trunk.size() + most_sampled_sections - 1) / most_sampled_sections;
  std::vector<LineCandidate> found;
  const auto add = [&](const ReferenceLine& line) {
    LineCandidate one{line};
    for (const DiameterSample& c : measured) {
      const double profile = diameter_behind_branches(line.at(c.s), sides, c.s);
      one.healthy.push_back(one.healthy.back() + healthy_weight(c, profile));
      one.wide.push_back(one.wide.back() + (!c.in_mouth && c.diameter > wide_ratio * profile));
      one.dilated.push_back(one.dilated.back() + (!c.in_mouth && c.diameter > dilated_ratio * profile));
    }
    found.push_back(std::move(one));
  };
  // level with the widest section: no section is wider, so this line is never ruled out
  add({widest, 0});
  for (std::size_t i = 0; i < trunk.size(); i += every) {
    add({trunk[i].diameter, 0});
    for (std::size_t j = i + every; j < trunk.size(); j += every) {
      const double slope = (trunk[j].diameter - trunk[i].diameter) / (trunk[j].s - trunk[i].s);
      const ReferenceLine line{trunk[i].diameter - slope * trunk[i].s, slope};
      if (slope < 0 && -slope < steepest_taper * line.at_start && line.at(trunk.back().s) > 0 &&
          line.at(trunk.front().s) < largest_extrapolation * widest)
        add(line);
    }
  }
  return found;
}

// One line, or two lines with a step between them, and how well they suit the sections.
struct ProfileChoice {
  double score = ruled_out_score; // see LineCandidate::score()
  double healthy = 0;             // number of healthy sections
  const LineCandidate *line = nullptr,
                      *behind = nullptr; // lines before and behind the step; `behind` may be null
  std::size_t last = 0, first = 0;       // indices of the sections at which the step begins and ends
  std::size_t dilated = 0, narrower = 0; // indices of a dilatation's first section, and of the first behind it
};

// The line of the best score over the sections from a to b: most of them lie on it, and hardly any above it. So a
// narrow stretch is not taken for healthy, however long, if the vessel is wide before or behind it.
ProfileChoice best_line(const std::vector<LineCandidate>& lines, std::size_t a, std::size_t b) {
  ProfileChoice best;
  for (const LineCandidate& one : lines)
    if (const double score = one.score(a, b); score > best.score)
      best = {score, one.healthy_between(a, b), &one};
  return best;
}

// The line of the best score over the sections outside a dilatation. A dilatation has 8 healthy sections or more on
// either side, and at least half of its own sections are wide.
ProfileChoice best_line_beside_dilatation(const std::vector<LineCandidate>& lines) {
  ProfileChoice best;
  for (const LineCandidate& one : lines) {
    const std::vector<int>& count = one.dilated;
    const std::size_t n = count.size() - 1;
    const auto first = static_cast<std::size_t>(std::upper_bound(count.begin(), count.end(), 0) - count.begin()) - 1;
    const auto last =
        static_cast<std::size_t>(std::lower_bound(count.begin(), count.end(), count.back()) - count.begin());
    if (first >= last || one.healthy_between(0, first) < fewest_sections ||
        one.healthy_between(last, n) < fewest_sections ||
        2 * (one.wide[last] - one.wide[first]) < static_cast<int>(last - first))
      continue;
    if (const double score = one.score(0, first) + one.score(last, n); score > best.score)
      best = {score, one.healthy_between(0, first) + one.healthy_between(last, n), &one, nullptr, 0, 0, first, last};
  }
  return best;
}

// The line above three quarters of the sections, by quantile regression over the candidates. It is the reference of a
// vessel in which no stretch is healthy: its diameter changes everywhere.
ReferenceLine upper_quartile_line(const std::vector<LineCandidate>& lines, const std::vector<DiameterSample>& measured,
                                  const SideBranches& sides) {
  ReferenceLine best;
  double least = 0;
  for (const LineCandidate& one : lines) {
    double cost = 0;
    for (const DiameterSample& c : measured) {
      const double above = c.diameter - diameter_behind_branches(one.line.at(c.s), sides, c.s);
      cost += above > 0 ? upper_quantile * above : (upper_quantile - 1) * above;
    }
    if (&one == &lines.front() || cost < least) {
      least = cost;
      best = one.line;
    }
  }
  return best;
}

// Fits a line to the sections from a to b by least squares, with healthy_weight() as their weights. `line` is the first
// guess.
ReferenceLine fit_line(ReferenceLine line, const std::vector<DiameterSample>& trunk, std::size_t a, std::size_t b) {
  for (int k = 0; k < 5; ++k) {
    double w = 0, ws = 0, wd = 0, wss = 0, wsd = 0;
    for (std::size_t i = a; i < b; ++i) {
      const DiameterSample& c = trunk[i];
      const double weight = std::max(healthy_weight(c, line.at(c.s)), 1e-6);
      w += weight;
      ws += weight * c.s;
      wd += weight * c.diameter;
      wss += weight * c.s * c.s;
      wsd += weight * c.s * c.diameter;
    }
    const double spread = wss - ws * ws / w;
    // a healthy vessel does not widen, nor does it taper as the shoulder of a lesion does
    line.slope =
        spread > 1e-9 * wss ? std::clamp((wsd - ws * wd / w) / spread, -steepest_taper * line.at_start, 0.0) : 0;
    line.at_start = (wd - line.slope * ws) / w;
  }
  return line;
}

// Whether a place s lies at a step of the reference from `from` to `to` (arc lengths, mm). `vessel` is the diameter
// before the step, mm. The axes of branches that leave at a small angle part up to two diameters behind the step.
bool is_at_step(double s, double from, double to, double vessel) {
  return s > from - vessel && s < to + 2 * vessel;
}

// Whether one of the closed stubs, given by arc lengths (mm), is at this step.
bool is_stub_at_step(const std::vector<double>& stubs, double from, double to, double vessel) {
  return std::any_of(stubs.begin(), stubs.end(), [&](double s) { return is_at_step(s, from, to, vessel); });
}

// The diameter (mm) of the widest side branch that leaves at this step; 0 if none does.
double branch_diameter_at_step(const SideBranches& branches, double from, double to, double vessel) {
  double widest = 0;
  for (const auto& [s, diameter] : branches.branches)
    if (is_at_step(s, from, to, vessel))
      widest = std::max(widest, diameter);
  return widest;
}

// The best pair of lines with a step down between them. Most sections on either side of the step are healthy. The step
// is at a side branch, or reaches from the last healthy section of the first line to the first one of the second. It is
// no deeper than at a fork into two equal branches, unless the flow split at a branch that leaves there says more. The
// diameter of a closed stub's branch is not known. So beside a stub the diameter may fall to the smaller one of two
// unequal branches.
// @param sides the branches past which the lines themselves step down
// @param branches all side branches
// @param stubs arc lengths of the closed stubs, mm
ProfileChoice best_step(const std::vector<LineCandidate>& lines, const std::vector<DiameterSample>& measured,
                        const SideBranches& sides, const SideBranches& branches, const std::vector<double>& stubs) {
  const std::size_t n = measured.size();
  const std::vector<DiameterSample> trunk = without_branch_steps(measured, sides);
  const auto is_mostly_healthy = [](double healthy, std::size_t all) {
    return healthy >= fewest_sections && 2 * healthy >= static_cast<double>(all);
  };
  ProfileChoice best;
  const auto attempt = [&](std::size_t k, bool at_a_branch) {
    if (k < fewest_sections || k + fewest_sections > n)
      return;
    const ProfileChoice before = best_line(lines, 0, k), behind = best_line(lines, k, n);
    if (!is_mostly_healthy(before.healthy, k) || !is_mostly_healthy(behind.healthy, n - k) ||
        before.score + behind.score <= best.score)
      return;
    std::size_t last = k, first = k;
    while (!at_a_branch && before.line->healthy_between(last - 1, k) == 0)
      --last;
    while (!at_a_branch && behind.line->healthy_between(k, first + 1) == 0)
      ++first;
    const double parent = fit_line(before.line->line, trunk, 0, k).at(measured[k].s);
    const double ratio = fit_line(behind.line->line, trunk, k, n).at(measured[k].s) / parent;
    const double side = branch_diameter_at_step(branches, measured[last].s, measured[first].s, parent);
    const double split = is_stub_at_step(stubs, measured[last].s, measured[first].s, parent)
                             ? 0
                             : diameter_behind_branches(parent, {{{0, side}}}, 1) / parent;
    const double deepest = std::min(deepest_step, std::max(deepest_step_by_branch, (1 - split_tolerance) * split));
    if (ratio >= deepest && ratio <= 1)
      best = {before.score + behind.score, before.healthy + behind.healthy, before.line, behind.line, last, first};
  };
  for (const auto& [at, diameter] : branches.branches)
    attempt(static_cast<std::size_t>(std::count_if(measured.begin(), measured.end(),
                                                   [at = at](const DiameterSample& c) { return c.s <= at; })),
            true);
  for (std::size_t k = fewest_sections; k + fewest_sections <= n;
       k += (n + most_sampled_sections - 1) / most_sampled_sections)
    attempt(k, false);
  return best;
}

ReferenceProfile fit_profile(const ProfileChoice& choice, const std::vector<DiameterSample>& measured,
                             const SideBranches& sides) {
  const std::vector<DiameterSample> trunk = without_branch_steps(measured, sides);
  if (!choice.behind)
    return {fit_line(choice.line->line, trunk, 0, trunk.size()), sides, {}};
  return {fit_line(choice.line->line, trunk, 0, choice.last), sides,
          ReferenceStep{measured[choice.last].s, measured[choice.first].s,
                        fit_line(choice.behind->line, trunk, choice.first, trunk.size())}};
}

// The sections without an ectasia and its flanks. An ectasia is a single stretch with at least 8 sections before and
// behind it. Its widest section is 1.5 times as wide as any of these.
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
  if (best.healthy < fewest_sections) {
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
    if (section.branch == branch && section.flag != "end")
      out.push_back({branches[branch].s[section.sample], section.equivalent_diameter(), section.flag == "ostium"});
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
