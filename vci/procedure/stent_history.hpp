// The history of a stent's rings: the diameters from which recoil is computed.
#pragma once
#include "vci/contact/contact.hpp"
#include "vci/devices/stent/stent.hpp"

namespace vci {

/// A deployed stent's dimensions in the course of the procedure.
struct StentHistory {
  std::string device, branch;
  double centre_s;
  Stent stent;
  std::vector<double> inflated_radii = {}; ///< of each ring at the end of the last inflation that filled it, mm
  double final_diameter = 0;               ///< mean over its rings, after the last extraction, mm
  double final_length = 0;                 ///< along its ring centres, mm
  double minimal_area = 0;                 ///< the smallest ring section after the last extraction, mm^2
  Vec3 first_end = Vec3::Zero();           ///< centre of its first ring after the last extraction
  Vec3 last_end = Vec3::Zero();            ///< centre of its last ring
  double inflated_diameter() const;        ///< mean over its rings, mm
};

/// Records the rings that inflated balloons fill. At the stent's own delivery these are all rings, later the rings with
/// at least half of their vertices in contact with a balloon.
/// @param balloons contact points of the balloons with the stent
void note_inflation(StentHistory& history, const System& system, const std::vector<ContactPoint>& balloons);
/// Records diameter, length, smallest section and ends after balloons are removed.
void note_extraction(StentHistory& history, const System& system);

} // namespace vci
