// The flat ends of the lumen by their tags: flattened and measured.
#pragma once
#include "core/types.hpp"
#include <set>

namespace anatomy {

/// Tags faces with the soup's region_id, by the nearest triangle of the soup.
void tag_from_soup(Mesh& mesh, const Soup& soup);

/// Tags scraps of caps as wall. The removal of self-intersections leaves such scraps beside a rim. A scrap is not
/// connected to a larger cap of the same tag, and its radius is below smallest_end. A tag in `single` keeps only its
/// largest cap, whatever the radius of the others.
void drop_scraps_of_caps(Mesh& mesh, const std::set<int>& single, std::vector<Repair>& repairs);

/// The largest move of a vertex.
struct Move {
  double distance = 0;    ///< mm
  double share = 0;       ///< the largest move in radii of its own cap, maybe of another vertex
  Vec3 to = Vec3::Zero(); ///< mm, the place after the move by `distance`
};

/// Moves the vertices of each tagged cap onto the cap's plane; returns the largest move.
Move flatten_caps(Mesh& mesh);

/// The ends by their tags, one per connected cap; retags them 1, 2, ... by falling area.
std::vector<End> measured_ends(Mesh& mesh);

} // namespace anatomy
