// A stent as its maker describes it.
#pragma once
#include <string>

namespace vci {

struct StentSpec {
  double nominal_diameter, length, crimped_diameter, maximal_diameter, strut_thickness; ///< mm
  int crowns, links;
  std::string balloon;               ///< name of the balloon that it is delivered on
  double hoop_stiffness = 0;         ///< N/mm
  double yield_strain = 0.03;        ///< of the hoop
  double axial_stiffness = 0.5;      ///< N/mm
  double bending_stiffness = 5.5;    ///< N mm^2
  double radial_strength_mpa = 0.22; ///< the maker's; gives the hoop stiffness where none is stated
  double recoil_percent = 4;         ///< the maker's
};

} // namespace vci
