// The healthy diameter along a branch, from its sections.
#pragma once
#include "measure/sections.hpp"
#include <optional>

namespace anatomy {

/// Healthy diameter of a branch as a linear function of arc length.
struct ReferenceLine {
  double at_start = 0, slope = 0; ///< mm, mm per mm
  double at(double s) const { return at_start + slope * s; }
};

/// A step down from one line to another. Between s = `from` and s = `to` (mm) the diameter is interpolated.
struct ReferenceStep {
  double from, to;
  ReferenceLine line; ///< the line behind the step
};

/// The side branches past which a reference steps down, and the exponent m of the steps.
struct SideBranches {
  /// For each branch k: the arc length s_k (mm) where it leaves, its diameter d_k (mm). Empty if there are no steps.
  std::vector<std::pair<double, double>> branches;
  double exponent = 2.55; ///< 2.55, by which the flow is split, or 3 (Murray 1926), or 7/3 (Huo and Kassab 2012)
};

/// Healthy equivalent diameter D (mm) along a branch: a straight line that does not widen, with a step down past each
/// side branch k of diameter d_k at s_k. D^m = line(s)^m - sum of d_k^m over s_k < s.
struct ReferenceProfile {
  ReferenceLine line;
  SideBranches sides;
  std::optional<ReferenceStep> step{}; ///< a further step, whose size follows from the sections
  double diameter(double s) const;     ///< mm, at arc length s (mm)
};

/// One profile for each branch, from the sections away from the ends, at a distance of 0.5 mm. A profile is the line on
/// which most sections lie, within 3 %; these sections count as healthy. "Many more" below means a quarter more.
/// - A line is ruled out if the lumen is wider than the line before or behind all its healthy sections. So a stretch is
///   read as a long narrowing of a wide vessel, not as a narrow vessel with a wide end.
/// - The steps past the side branches are kept unless over 8 more sections lie on a profile without them. Their
///   exponent is 2.55 unless 3 or 7/3 finds many more healthy sections. One step is left out, with a warning, if that
///   finds many more. Its branch may bring blood, as a graft does.
/// - A dilatation, a stretch wider than the healthy vessel on both sides, is left out if that finds many more healthy
///   sections. An ectasia, 1.5 times as wide as all sections before and behind it, is always left out.
/// - One more step, of the size that the sections show, is taken if that finds many more healthy sections. It is no
///   deeper than past a fork into two equal branches, or at a closed stub into two unequal ones. Where no branch
///   leaves, the step is taken for a branch that is missing in the surface.
/// - If fewer than 8 sections are healthy by the best profile, and less than a quarter, no stretch is healthy. The
///   profile is then the line above three quarters of the sections, with a warning. No line is wider at its start than
///   1.25 times the widest section.
/// - A branch with fewer than 8 such sections has a constant profile, twice the median of its inscribed radius.
/// `notes` takes a warning of each dilatation, ectasia and step without a branch, and a note of each constant profile.
/// If twice as many sections as the healthy ones lie on a narrower line, a warning gives the diameter by that line too.
std::vector<ReferenceProfile> reference_profiles(const std::vector<Branch>& branches,
                                                 const std::vector<Section>& sections, std::vector<Repair>& notes,
                                                 const std::vector<ClosedStub>& stubs = {});

/// A section away from the ends: arc length and equivalent diameter (mm), and whether a side branch's mouth widens it.
struct DiameterSample {
  double s, diameter;
  bool in_mouth;
};

/// The sections of one branch away from the ends (flag ok or ostium), in their order along it.
std::vector<DiameterSample> diameter_samples(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                                             std::size_t branch);

} // namespace anatomy
