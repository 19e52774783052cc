// What is refused or warned of between the steps from surface to anatomy.
#pragma once
#include "ends/ends.hpp"
#include "ends/find_ends.hpp"
#include "remesh/remesh.hpp"

namespace anatomy {

/// Throws InputError with the place where a closed mesh has a handle: vessels that fuse beside each other, as hairpins
/// do in a segmentation, leave one. most: handles that are let pass. Removes isolated vertices and garbage.
void check_no_handle(Mesh& mesh, long most = 0);

/// Handles of a few vessels that touch; more are noise.
constexpr long few_rings = 4;

/// Throws InputError with the wall's roughness and its roughest place if fewer than two ends were found because of it.
/// On a wall as rough as its triangles no patch is flat.
void check_ends_seen(const Mesh& mesh, const std::vector<End>& ends);

/// Throws InputError with the place of a closed tube that is longer than wide and has no end: an outlet of a coronary
/// tree that would be lost. It only warns if the tube is as short as wide, or if the user has named all ends (`named`).
void check_no_stub(const Mesh& mesh, const std::vector<End>& ends, bool named, std::vector<Repair>& repairs);

/// Warns of each closed stub that counts as wall, as a branch may have been cut off there. Stubs that are already among
/// the `candidates` for ends are left out.
void warn_of_stubs(const Mesh& mesh, const std::vector<End>& ends, const std::vector<Candidate>& candidates,
                   std::vector<Repair>& repairs);

/// Notes the largest move of the `ends` caps, with the wall's rim, onto their planes. Above a tenth of a cap's radius
/// it is a warning. A smaller move changes the cap's area by half a per cent at most, and sections so near are not
/// used.
void report_move(std::vector<Repair>& repairs, const Move& move, std::size_t ends);

/// Warns of a corner below 30 degrees in the new wall, with its place.
void warn_of_corner(std::vector<Repair>& repairs, const Quality& quality);

} // namespace anatomy
