// Refusals and warnings between the steps from surface to anatomy.
#pragma once
#include "ends/ends.hpp"
#include "ends/find_ends.hpp"
#include "remesh/remesh.hpp"

namespace anatomy {

/// Throws InputError with the place of a handle if the closed mesh has more than `most`. Vessels that fuse side by side
/// in a segmentation, such as hairpins, make a handle. Removes isolated vertices and garbage.
void check_no_handle(Mesh& mesh, long most = 0);

/// Largest number of handles from vessels that touch; more come from noise.
constexpr long few_rings = 4;

/// Throws InputError with the wall's roughness and its roughest place if fewer than two ends were found because of it.
/// On a wall as rough as its triangles no patch is flat.
void check_ends_seen(const Mesh& mesh, const std::vector<End>& ends);

/// Throws InputError with the place of a closed tube that is longer than wide and has no end, since an outlet would be
/// lost. It only warns if the tube is not longer than wide, or if the user has named all ends (`named`).
void check_no_stub(const Mesh& mesh, const std::vector<End>& ends, bool named, std::vector<Repair>& repairs);

/// Throws InputError with the place of a closed stub that is wider than every end. The inlet is the largest end, so it
/// may be the stub that blood comes from, such as a short left main.
void check_no_wide_stub(const Mesh& mesh, const std::vector<End>& ends);

/// Warns of each closed stub that counts as wall, since a branch may have been cut off there. Stubs that are already
/// among the `candidates` for ends are left out. Throws InputError if the farthest place of the lumen is at no end.
void warn_of_stubs(const Mesh& mesh, const std::vector<End>& ends, const std::vector<Candidate>& candidates,
                   std::vector<Repair>& repairs);

/// The tips of all closed stubs, whether they count as wall by the user's word or by the search for ends.
std::vector<Vec3> tips_of_stubs(const Mesh& mesh, const std::vector<End>& ends);

/// Reports the largest move of the caps of `ends`, with the wall's rim, onto their planes. A move of more than a tenth
/// of the cap's radius gives a warning. A smaller one changes the cap's area by at most half a per cent, and no section
/// so near is used.
void report_move(std::vector<Repair>& repairs, const Move& move, std::size_t ends);

/// Warns of a corner below 30 degrees in the new wall, with its place.
void warn_of_corner(std::vector<Repair>& repairs, const Quality& quality);

} // namespace anatomy
