// The lines that a healthy reference is chosen from: how many sections of a branch lie on each, and how many above it.
#pragma once
#include "measure/reference.hpp"
#include <algorithm>

namespace anatomy {

/// A section is healthy if it differs from the profile by less than this share of its diameter.
inline constexpr double healthy_tolerance = 0.03;
inline constexpr double ruled_out_score = -1e9; /// score of a line that cannot be the reference
/// Distance (mm) of the samples that a profile is fitted to. The numbers of sections below are then lengths, and the
/// profile does not depend on the spacing of the sections.
inline constexpr double sample_spacing = 0.5;
inline constexpr int fewest_sections = 8; /// least number of samples (4 mm) for a profile, and for each of its parts

/// The diameter (mm) at s behind the side branches. `line` (mm) is the diameter as if no branch had left before s.
double diameter_behind_branches(double line, const SideBranches& sides, double s);

bool is_less_wide(const DiameterSample& a, const DiameterSample& b);

/// A line, with running counts of the sections. Element k of each list is a count among the first k sections: `healthy`
/// counts those on the line (sum of healthy_weight()), `wide` those above it, `dilated` those far above it.
struct LineCandidate {
  ReferenceLine line;
  std::vector<double> healthy{0};
  std::vector<int> wide{0}, dilated{0};

  double healthy_between(std::size_t a, std::size_t b) const { return healthy[b] - healthy[a]; }

  /// The number of healthy sections from a to b, less the number of wide ones. The line is ruled out if 8 wide sections
  /// in all lie before the first 8 healthy ones and behind the last 8. Then they are no bulge of a healthy vessel. They
  /// are the healthy vessel, and the line follows a long narrowing.
  double score(std::size_t a, std::size_t b) const {
    const auto reached = [&](double count) {
      return static_cast<std::size_t>(std::lower_bound(healthy.begin(), healthy.end(), count) - healthy.begin());
    };
    const int before = wide[reached(std::min(healthy[a] + fewest_sections, healthy[b]))] - wide[a];
    const int behind = wide[b] - wide[std::max(a, reached(std::max(healthy[b] - fewest_sections, healthy[a])))];
    return before + behind < fewest_sections ? healthy_between(a, b) - (wide[b] - wide[a]) : ruled_out_score;
  }
};

/// One line, or two lines with a step between them, and how well they suit the sections.
struct ProfileChoice {
  double score = ruled_out_score; ///< see LineCandidate::score()
  double healthy = 0;             ///< number of healthy sections
  const LineCandidate *line = nullptr,
                      *behind = nullptr; ///< lines before and behind the step; `behind` may be null
  std::size_t last = 0, first = 0;       ///< indices of the sections at which the step begins and ends
  std::size_t dilated = 0, narrower = 0; ///< indices of a dilatation's first section, and of the first behind it
};

/// The lines that are tried: level lines, and lines through pairs of sections. The latter fall along the vessel, by no
/// more than `steepest_taper`.
std::vector<LineCandidate> candidate_lines(const std::vector<DiameterSample>& measured, const SideBranches& sides);

/// The line of the best score over the sections from a to b: most of them lie on it, and hardly any above it. So a
/// narrow stretch is not taken for healthy, however long, if the vessel is wide before or behind it.
ProfileChoice best_line(const std::vector<LineCandidate>& lines, std::size_t a, std::size_t b);

/// The line of the best score over the sections outside a dilatation. A dilatation has 8 healthy sections or more on
/// either side, and at least half of its own sections are wide.
ProfileChoice best_line_beside_dilatation(const std::vector<LineCandidate>& lines);

/// The best pair of lines with a step down between them. Most sections on either side of the step are healthy. The step
/// is at a side branch, or reaches from the last healthy section of the first line to the first one of the second. It
/// is no deeper than at a fork into two equal branches, unless the flow split at a branch that leaves there says more.
/// The diameter of a closed stub's branch is not known. So beside a stub the diameter may fall to the smaller one of
/// two unequal branches.
/// @param sides the branches past which the lines themselves step down
/// @param branches all side branches
/// @param stubs arc lengths of the closed stubs, mm
ProfileChoice best_step(const std::vector<LineCandidate>& lines, const std::vector<DiameterSample>& measured,
                        const SideBranches& sides, const SideBranches& branches, const std::vector<double>& stubs);

/// The line above three quarters of the sections, by quantile regression over the candidates. It is the reference of a
/// vessel in which no stretch is healthy: its diameter changes everywhere.
ReferenceLine upper_quartile_line(const std::vector<LineCandidate>& lines, const std::vector<DiameterSample>& measured,
                                  const SideBranches& sides);

/// The diameter (mm) of the widest side branch that leaves at this step; 0 if none does.
double branch_diameter_at_step(const SideBranches& branches, double from, double to, double vessel);

/// The profile of a choice, with its lines fitted to the healthy sections by least squares.
ReferenceProfile fit_profile(const ProfileChoice& choice, const std::vector<DiameterSample>& measured,
                             const SideBranches& sides);

} // namespace anatomy
