#include "measure/reference_lines.hpp"

namespace anatomy {
namespace {

constexpr double wide_ratio = 1.08;     // a section is wide above this ratio to the profile; ostia may reach it
constexpr double upper_quantile = 0.75; // share of the sections below the reference of a vessel without healthy stretch
// Largest ratio of a reference to the widest section. A line through a healthy distal part rises above the proximal
// sections of a vessel that is narrowed there. But a diameter that the vessel has nowhere is not its healthy one.
constexpr double largest_extrapolation = 1.25;
// Lines are tried through pairs of at most this many sections.
constexpr std::size_t most_sampled_sections = 80;
constexpr double dilated_ratio = 1.15; // a section is dilated above this ratio to the profile
// Least ratio of the diameter behind a step to the one before it. A fork into two equal branches has 0.737. A fork into
// branches of 0.6 and 0.87 has 0.6. Both follow from D = 0.678 (d1 + d2), Finet 2007.
constexpr double deepest_step = 0.737;         // where no stub and no wide branch is known
constexpr double deepest_step_by_branch = 0.6; // beside a closed stub or a wide branch
constexpr double split_tolerance = 0.1;   // share by which a step at a branch may be deeper than the flow split says
constexpr double least_trunk_share = 0.1; // share of D^m that is left behind side branches, however wide they are
// Largest taper of the reference, as a share of its first diameter per mm. An LAD tapers by 0.005 per mm (3.7 to 1.9 mm
// over 100 mm, Dodge 1992).
constexpr double steepest_taper = 0.015;

// Sum of d_k^m over the side branches that leave before s, in mm^m.
double branch_power_sum(const SideBranches& sides, double s) {
  double sum = 0;
  for (const auto& [at, diameter] : sides.branches)
    if (at < s)
      sum += std::pow(diameter, sides.exponent);
  return sum;
}

} // namespace

double diameter_behind_branches(double line, const SideBranches& sides, double s) {
  if (sides.branches.empty())
    return line;
  const double trunk = std::pow(line, sides.exponent);
  return std::pow(std::max(trunk - branch_power_sum(sides, s), least_trunk_share * trunk), 1 / sides.exponent);
}

bool is_less_wide(const DiameterSample& a, const DiameterSample& b) {
  return a.diameter < b.diameter;
}

namespace {

// The sections with the diameters that they would have if no side branch had left before them.
std::vector<DiameterSample> without_branch_steps(std::vector<DiameterSample> measured, const SideBranches& sides) {
  for (DiameterSample& c : measured)
    c.diameter = std::pow(std::pow(c.diameter, sides.exponent) + branch_power_sum(sides, c.s), 1 / sides.exponent);
  return measured;
}

// Weight of a section as healthy: 1 on the profile (mm), falling to 0 where its diameter differs by the share
// `healthy_tolerance`.
double healthy_weight(const DiameterSample& c, double profile) {
  const double off = (c.diameter - profile) / (healthy_tolerance * c.diameter);
  return std::max(0.0, 1 - off * off);
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

} // namespace

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

ProfileChoice best_line(const std::vector<LineCandidate>& lines, std::size_t a, std::size_t b) {
  ProfileChoice best;
  for (const LineCandidate& one : lines)
    if (const double score = one.score(a, b); score > best.score)
      best = {score, one.healthy_between(a, b), &one};
  return best;
}

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

double branch_diameter_at_step(const SideBranches& branches, double from, double to, double vessel) {
  double widest = 0;
  for (const auto& [s, diameter] : branches.branches)
    if (is_at_step(s, from, to, vessel))
      widest = std::max(widest, diameter);
  return widest;
}

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

} // namespace anatomy
