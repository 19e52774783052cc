// What is refused or warned of between the steps from surface to anatomy.
#pragma once
#include "ends/ends.hpp"
#include "remesh/remesh.hpp"

namespace anatomy {

/// Throws InputError with the place where a closed mesh has a handle: vessels that fuse beside each other, as hairpins
/// do in a segmentation, leave one. Removes isolated vertices and garbage.
void check_no_handle(Mesh& mesh);

/// Throws InputError with the wall's roughness and its roughest place where fewer than two ends were found because of
/// it: on a wall as rough as its triangles no patch is flat.
void check_ends_seen(const Mesh& mesh, const std::vector<End>& ends);

/// Notes by how much `ends` caps were moved onto their planes; above 10 um it is a warning, since the wall's rim went
/// with them.
void report_move(std::vector<Repair>& repairs, const Move& move, std::size_t ends);

/// Warns of a corner below 30 degrees in the new wall, with its place.
void warn_of_corner(std::vector<Repair>& repairs, const Quality& quality);

} // namespace anatomy
