// Settings of solver, contact and grids.
#pragma once
#include "vci/contact/contact.hpp"
#include "vci/solver/integrator.hpp"

namespace vci {

struct Numerics {
  IntegratorSettings integrator;
  ContactSettings contact;
  double tie_stiffness = 60;              ///< stiffness per area of the ties between stent and wall, MPa/mm
  double region_margin = 6;               ///< mm: the wall moves up to this distance beyond the devices' ends
  double device_edge = 0.45;              ///< edge length of the device meshes at nominal diameter, mm
  double contact_pressure_fraction = 0.5; ///< pressure in a step's first stage over the step's pressure
};

} // namespace vci
