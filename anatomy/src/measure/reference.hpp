// The healthy diameter along a branch, from its sections.
#pragma once
#include "measure/sections.hpp"

namespace anatomy {

/// Healthy equivalent diameter D (mm) along a branch: a straight line that does not widen, with a step down past each
/// side branch k of diameter d_k at s_k. D^m = (at_start + slope s)^m - sum of d_k^m over s_k < s. The flow
/// is split by the same exponent m = 2.55.
struct ReferenceProfile {
  double at_start = 0, slope = 0;
  std::vector<std::pair<double, double>> sides; ///< (s_k, d_k), mm; empty where the diameters show no such steps
  double diameter(double s) const;
};

/// One profile per branch, from the sections away from the ends.
/// - It is fitted robustly to their upper envelope, so that narrowings and ostia do not move it.
/// - In a branch with a dilatation it is fitted to the median of the sections instead, if that finds many more healthy
///   sections.
/// - An ectasia, 1.5 times as wide as all sections before and behind it, is left out.
/// - Steps at the side branches are kept if more sections then lie on the profile.
/// - A branch with fewer than 8 such sections has a constant profile, twice the median of its inscribed radius.
/// `notes` takes a warning of each dilatation, ectasia and constant profile.
std::vector<ReferenceProfile> reference_profiles(const std::vector<Branch>& branches,
                                                 const std::vector<Section>& sections, std::vector<Repair>& notes);

/// A section away from the ends: arc length and equivalent diameter (mm), and whether a side branch's mouth widens it.
struct Calibre {
  double s, diameter;
  bool mouth;
};
std::vector<Calibre> calibres(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                              std::size_t branch);

} // namespace anatomy
