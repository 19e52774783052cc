// A stent as its maker describes it.
#pragma once
#include <optional>
#include <string>

namespace vci {

struct StentSpec {
  double nominal_diameter, length, crimped_diameter, maximal_diameter, strut_thickness; ///< mm
  int crowns, links;   ///< number of crowns in a row of struts, and of links between two rows
  std::string balloon; ///< name of the balloon that delivers the stent
  std::optional<double> stated_hoop_stiffness = std::nullopt; ///< N/mm; none: it follows from the radial strength
  double axial_stiffness = 0.5;      ///< least axial force per strain and length of circumference, N/mm
  double bending_stiffness = 20;     ///< N mm^2
  double radial_strength_mpa = 0.22; ///< stated by the maker; gives the hoop stiffness if none is stated
  double recoil_percent = 4.5;       ///< free recoil in air stated by the maker, of the inflated diameter

  /// Hoop strain at which a ring yields. A ring opened beyond yield recovers just this strain when the balloon is
  /// removed, so the strain follows from the maker's free recoil.
  double yield_strain() const { return recoil_percent / (100 - recoil_percent); }

  /// Hoop tension per axial length and strain, N/mm. If it is not stated, it follows from Laplace's law: the expanded
  /// ring yields under just the outside pressure that its maker states.
  double hoop_stiffness() const {
    return stated_hoop_stiffness.value_or(0.5 * radial_strength_mpa * nominal_diameter / yield_strain());
  }
};

} // namespace vci
