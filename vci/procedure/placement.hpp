// Where devices start: small enough to fit, apart from one another, and excluded from contact with stents they leave.
#pragma once
#include "vci/contact/contact.hpp"
#include "vci/devices/stent/stent.hpp"

namespace vci {

/// A device about to be placed: its rings' frames along the vessel and its radius once inflated, mm.
struct Course {
  RingGrid grid;
  std::vector<Frame> frames;
  double inflated_radius;
};

constexpr double start_clearance = 0.03; ///< mm between a device and what surrounds it at the start

/// Where a device leaves a standing stent through its side (a side branch's device through the main branch's stent, and
/// the other way round), its struts are pushed aside: the stent's vertices in that window are excluded, and so are the
/// device's vertices that will come to lie outside. Inside, the two touch as nested tubes. Empty flags where the device
/// stays within the stent.
ContactSides leaving_through(const System& system, const Stent& stent, const Course& device);

/// Radii (mm) of a device's rings that keep clear of every surface present, at most the crimped one.
/// @param sides per body of the system, what of it the device does not see; bodies beyond its end are seen whole
std::vector<double> start_radii(const System& system, const Course& device, double crimped_diameter,
                                const std::vector<ContactSides>& sides);

/// Moves two devices' axes apart where they share a vessel, so that both fit side by side at a diameter (mm).
void set_side_by_side(Course& one, Course& other, double crimped_diameter);

} // namespace vci
