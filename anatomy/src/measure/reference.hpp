// The healthy diameter along a branch, from its sections.
#pragma once
#include "measure/sections.hpp"

namespace anatomy {

/// Healthy equivalent diameter (mm) along a branch: a straight line that does not widen and loses, past each side
/// branch k, what that branch carries: D^m = (at_start + slope s)^m - sum of d_k^m over s_k < s, m = 2.55 (the exponent
/// by which flow is split).
struct ReferenceProfile {
  double at_start = 0, slope = 0;
  std::vector<std::pair<double, double>> sides; ///< (s_k, d_k), mm; empty where the diameters show no such steps
  double diameter(double s) const;
};

/// One profile per branch, from the sections away from the ends.
/// - It is fitted robustly to their upper envelope, so that narrowings and ostia do not move it.
/// - In a branch with a dilatation it goes through the middle of the sections instead, where that finds more healthy
///   ones on both sides of the wide stretch.
/// - An ectasia, 1.5 times as wide as all before and behind it, is left out.
/// - Steps at the side branches are kept if they bring more sections to the profile.
/// - A branch with fewer than 8 such sections has a constant profile, twice the median of its inscribed radius.
/// `notes` takes a warning of each dilatation, ectasia and constant profile.
std::vector<ReferenceProfile> reference_profiles(const std::vector<Branch>& branches,
                                                 const std::vector<Section>& sections, std::vector<Repair>& notes);

/// Arc length and equivalent diameter of a branch's sections away from the ends; whether a side branch's mouth widens
/// it.
struct Calibre {
  double s, diameter;
  bool mouth;
};
std::vector<Calibre> calibres(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                              std::size_t branch);

} // namespace anatomy
