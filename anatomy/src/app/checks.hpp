// Checks between the steps from surface to anatomy, with errors and warnings.
#pragma once
#include "ends/ends.hpp"
#include "ends/find_ends.hpp"
#include "remesh/remesh.hpp"

namespace anatomy {

/// Throws InputError with the place of a handle if the closed mesh has more than `most_handles` handles, or if it falls
/// into pieces. Vessels that fuse side by side in a segmentation, such as hairpins, make a handle. Removes isolated
/// vertices and the mesh's garbage.
void check_no_handle(Mesh& mesh, long most_handles = 0);

/// Largest number of handles that is ascribed to vessels that touch; a mesh with more is taken for noisy.
constexpr long most_touching_rings = 4;

/// Throws InputError with the wall's roughness and its roughest place if fewer than two ends were found and the wall is
/// rough. Ends are recognised by their flat caps. Noise that tilts the triangles leaves no part flat.
void check_ends_seen(const Mesh& mesh, const std::vector<End>& ends);

/// Throws InputError with the place of a closed branch that stands out by more than 1.5 of its radii, since an outlet
/// would be lost. It only warns of a shorter one that stands out by a radius or more, or if the user has named all ends
/// (`all_named`).
void check_no_stub(const Mesh& mesh, const std::vector<End>& ends, bool all_named, std::vector<Repair>& repairs);

/// Throws InputError with the place of a closed stub that is wider than every end. The largest end is taken for the
/// inlet, but blood may come through the stub, such as a short left main.
void check_no_wide_stub(const Mesh& mesh, const std::vector<End>& ends);

/// Warns of each closed stub that counts as wall, since a branch may have been cut off there. Stubs that are already
/// among the `candidates` for ends are left out. Throws InputError if one of the two extremities of the lumen is at no
/// end.
void warn_of_stubs(const Mesh& mesh, const std::vector<End>& ends, const std::vector<EndCandidate>& candidates,
                   std::vector<Repair>& repairs);

/// The tips (mm) of all closed stubs, whether the user or the search for ends has left them as wall.
std::vector<Vec3> stub_tips(const Mesh& mesh, const std::vector<End>& ends);

/// Reports how far the caps, with the wall's rims, were moved onto their planes. `ends` is the number of caps. A move
/// of more than a tenth of the cap's radius gives a warning. A smaller one changes the cap's area by at most half a per
/// cent, and no section so near to a cap is used.
void report_cap_move(std::vector<Repair>& repairs, const CapMove& move, std::size_t ends);

/// Warns of an angle below 30 degrees in the new wall, with its place.
void warn_of_small_angle(std::vector<Repair>& repairs, const Quality& quality);

} // namespace anatomy
