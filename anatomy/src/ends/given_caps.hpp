// Opens the surface at the ends that the user gives as cap files.
#pragma once
#include "files/cap_files.hpp"
#include "repair/repair.hpp"

namespace anatomy {

/// Returns a test that tells whether one of the caps closes the vessel at a loop: the rim lies on the cap, and the
/// faces beside the rim do not. So a hole in a closed end is no end.
IsGivenEnd ends_at_caps(const std::vector<GivenCap>& caps);

/// Opens the mesh at each cap and returns the centres of the openings (mm), in the order of the caps. The faces that
/// lie on the cap are removed. The rim that is left is treated like the rim of any open end. So a cap may be a dome, or
/// its rim may lie in no plane. If the mesh is open there already, or its own tags say that it ends there, nothing is
/// removed. Throws InputError if no faces lie on the cap, or if the surface without them has not exactly one opening
/// there.
std::vector<Vec3> open_given_caps(Mesh& mesh, const std::vector<GivenCap>& caps);

} // namespace anatomy
