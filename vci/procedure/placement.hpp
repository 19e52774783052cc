// Starting positions and sizes of devices, so that they fit into the lumen and do not touch one another. A device may
// leave a stent through its side.
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

/// Excludes vertices from contact where a device leaves an implanted stent through its side. This may be a device of a
/// side branch in a stent of the main branch, or the other way round. In reality the device pushes the struts aside.
/// Here two groups of vertices are excluded: the stent's vertices in the window thus opened, and the device's vertices
/// that will be outside the stent. Elsewhere both touch as nested tubes. The flags are empty if the device stays within
/// the stent.
ContactScope exclude_side_exit(const System& system, const Stent& stent, const DeviceLayout& device);

/// Starting radius (mm) of each ring of a device: at most the crimped radius, and small enough to keep clear of every
/// surface in the system, but at least 0.05 mm.
/// @param scopes excluded vertices of each body of the system; bodies beyond the end of the list have none
std::vector<double> start_radii(const System& system, const DeviceLayout& device, double crimped_diameter,
                                const std::vector<ContactScope>& scopes);

/// Moves the axes of two devices apart where both lie in one vessel, so that devices of this diameter (mm) fit side by
/// side.
void set_side_by_side(DeviceLayout& one, DeviceLayout& other, double crimped_diameter);

} // namespace vci
