// The healthy diameter along a branch, from its sections.
#pragma once
#include "measure/sections.hpp"
#include <optional>

namespace anatomy {

struct ReferenceLine {
  double at_start = 0, slope = 0; ///< mm, mm per mm
  double at(double s) const { return at_start + slope * s; }
};

/// A step down from one line to another. The reference is interpolated between the two, from s = `from` to `to`, mm.
struct ReferenceStep {
  double from, to;
  ReferenceLine line; ///< behind it
};

/// The side branches past which a reference steps down, and the exponent m of the steps.
struct Sides {
  std::vector<std::pair<double, double>> branches; ///< (s_k, d_k), mm; empty where the diameters show no such steps
  double exponent = 2.55;                          ///< by which the flow is split, or 3 (Murray 1926), or 7/3 (HK)
};

/// Healthy equivalent diameter D (mm) along a branch: a straight line that does not widen, with a step down past each
/// side branch k of diameter d_k at s_k. D^m = line(s)^m - sum of d_k^m over s_k < s.
struct ReferenceProfile {
  ReferenceLine line;
  Sides sides;
  std::optional<ReferenceStep> step{}; ///< one of another size
  double diameter(double s) const;
};

/// One profile per branch, from the sections away from the ends. It is the line that most sections lie on, within 3 %.
/// - Lumen that is wider than the line before or behind all its healthy sections rules the line out. Of two readings, a
///   long narrowing or a widening at an end, the narrowing is so taken.
/// - The steps at the side branches are kept unless more sections lie on a profile without them. Their exponent is 2.55
///   unless 3 or 7/3 finds many more healthy sections. One of them, which may bring blood as a graft does, is left out
///   if that finds many more. This is warned of.
/// - A dilatation, a stretch wider than the healthy vessel on both sides, is left out if that finds many more healthy
///   sections. An ectasia, 1.5 times as wide as all sections before and behind it, is always left out.
/// - One more step, of the size that the sections show, is taken if that finds many more healthy sections. It is no
///   deeper than past a fork into two equal branches, or at a closed stub into two unequal ones. Where no branch
///   leaves, it stands for one that the surface lacks.
/// - A branch with fewer than 8 such sections has a constant profile, twice the median of its inscribed radius.
/// `notes` takes a warning of each dilatation, ectasia and step without a branch, and a note of each constant profile.
/// If twice as many sections as the healthy ones lie on a narrower line, a warning states that reading as well.
std::vector<ReferenceProfile> reference_profiles(const std::vector<Branch>& branches,
                                                 const std::vector<Section>& sections, std::vector<Repair>& notes,
                                                 const std::vector<ClosedStub>& stubs = {});

/// A section away from the ends: arc length and equivalent diameter (mm), and whether a side branch's mouth widens it.
struct Calibre {
  double s, diameter;
  bool mouth;
};
std::vector<Calibre> calibres(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                              std::size_t branch);

} // namespace anatomy
