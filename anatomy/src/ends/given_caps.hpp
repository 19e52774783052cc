// Ends that the user gives as files.
#pragma once
#include "files/cap_files.hpp"

namespace anatomy {

/// Tags the faces of the closed mesh that lie on a given cap, unless an end that was capped before (tagged) is there.
/// Throws InputError where neither is, or where a cap is not flat.
void tag_given_caps(Mesh& mesh, const std::vector<GivenCap>& caps);

} // namespace anatomy
