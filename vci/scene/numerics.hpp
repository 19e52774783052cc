// Settings of solver, contact and grids.
#pragma once
#include "vci/contact/contact.hpp"
#include "vci/solver/integrator.hpp"

namespace vci {

struct Numerics {
  IntegratorSettings integrator;
  ContactSettings contact;
  double tie_stiffness = 60;              ///< MPa/mm
  double region_margin = 6;               ///< mm beyond the devices in which the wall moves
  double device_edge = 0.45;              ///< mm
  double contact_pressure_fraction = 0.5; ///< of a step's pressure, at its first stage
};

} // namespace vci
