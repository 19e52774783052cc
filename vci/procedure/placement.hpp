// Starting positions and sizes of devices: they fit, do not touch one another, and may leave a stent through its side.
#pragma once
#include "vci/contact/contact.hpp"
#include "vci/devices/stent/stent.hpp"

namespace vci {

/// A device about to be placed: its rings' frames along the vessel and its radius once inflated, mm.
struct DeviceLayout {
  RingGrid grid;
  std::vector<Frame> frames;
  double inflated_radius;
};

constexpr double start_clearance = 0.03; ///< mm between a device and the surfaces round it at the start

/// A device may leave an implanted stent through its side: a device of a side branch through the stent of the main
/// branch, or the other way round. It pushes the struts aside. So two groups of vertices are excluded from contact: the
/// stent's vertices in this window, and the device's vertices that will be outside the stent. Inside, the two touch as
/// nested tubes. The flags are empty if the device stays within the stent.
ContactSides leaving_through(const System& system, const Stent& stent, const DeviceLayout& device);

/// Radii (mm) of a device's rings that keep clear of every surface present, at most the crimped one.
/// @param sides for each body of the system its excluded vertices; bodies beyond the end of the list have none
std::vector<double> start_radii(const System& system, const DeviceLayout& device, double crimped_diameter,
                                const std::vector<ContactSides>& sides);

/// Moves two devices' axes apart where they share a vessel, so that both fit side by side with this diameter (mm).
void set_side_by_side(DeviceLayout& one, DeviceLayout& other, double crimped_diameter);

} // namespace vci
