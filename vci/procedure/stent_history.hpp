// A stent's dimensions when inflated and after balloons were removed, from which recoil is computed.
#pragma once
#include "vci/contact/contact.hpp"
#include "vci/devices/stent/stent.hpp"

namespace vci {

/// A deployed stent with its dimensions at the ends of stages.
struct StentHistory {
  std::string device, branch;
  double centre_s; ///< arc length of the stent's centre along its branch, mm
  Stent stent;
  std::vector<double> inflated_radii = {}; ///< radius of each ring after the last inflation that filled it, mm
  double final_diameter = 0;               ///< mean over the stent's rings, after the last extraction of balloons, mm
  double final_length = 0;                 ///< length of the line through the rings' centres, mm
  double minimal_area = 0;                 ///< smallest cross-section at a ring after the last extraction, mm^2
  Vec3 first_end = Vec3::Zero();           ///< centre of the first ring after the last extraction, mm
  Vec3 last_end = Vec3::Zero();            ///< centre of the last ring after the last extraction, mm
  double inflated_diameter() const;        ///< mean of inflated_radii, times two, mm
};

/// Records the radii of the rings that inflated balloons fill. When the stent is delivered these are all rings, later
/// those with at least half of their vertices in contact with a balloon.
/// @param balloons contact points of the balloons with the stent
void record_inflation(StentHistory& history, const System& system, const std::vector<ContactPoint>& balloons);
/// Records diameter, length, smallest section and ends after balloons are removed.
void record_extraction(StentHistory& history, const System& system);

} // namespace vci
