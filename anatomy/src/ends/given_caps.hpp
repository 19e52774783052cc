// Ends that the user gives as files.
#pragma once
#include "files/cap_files.hpp"

namespace anatomy {

/// Removes the faces that lie on a given cap, so that the end is open and its rim goes the way of every open end. A cap
/// that lies at an opening, or at an end that the surface itself tags, changes nothing. What the cap looks like does
/// not matter: it may be a dome, or its rim may lie in no plane. Throws InputError where the surface has no such faces,
/// or where removing them leaves anything but one opening more.
void open_given_caps(Mesh& mesh, const std::vector<GivenCap>& caps);

} // namespace anatomy
