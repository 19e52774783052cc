// Brings devices into the vessel, adds their contacts, and takes them out again.
#pragma once
#include "vci/procedure/run_state.hpp"

namespace vci {

/// Places a step's devices on the current axes, with contacts to all bodies in the system.
void place_devices(RunState& run, const Step& step);

/// Removes the step's balloons and their contacts from the system.
void remove_balloons(RunState& run);

/// The active contact points between the body number `outer` and the devices inside it.
/// @param of_stents true: only contacts of stents; false: only contacts of balloons
std::vector<ContactPoint> contacts_on_body(RunState& run, int outer, bool of_stents);

/// Ties the stents to the wall where they touch it. Does nothing if the scene sets no tie stiffness.
void tie_stents(RunState& run);

} // namespace vci
