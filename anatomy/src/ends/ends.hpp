// Tags, flattens and measures the flat ends of the lumen.
#pragma once
#include "core/types.hpp"
#include <set>

namespace anatomy {

/// Gives each face of the mesh the region_id of the soup's nearest triangle.
void tag_from_soup(Mesh& mesh, const Soup& soup);

/// Tags scraps of caps as wall. The removal of self-intersections leaves such scraps beside a rim. A scrap is not
/// connected to a larger cap of the same tag, and its radius is below smallest_end (repair/loops.hpp). Of a tag in
/// `single_cap_tags` only the largest connected cap is kept, whatever the radius of the others.
void drop_scraps_of_caps(Mesh& mesh, const std::set<int>& single_cap_tags, std::vector<Repair>& repairs);

/// How far flatten_caps has moved vertices at most.
struct CapMove {
  double distance = 0;          ///< mm, the largest move
  double share = 0;             ///< largest ratio of a vertex's move to the radius of its cap; may be at another vertex
  Vec3 moved_to = Vec3::Zero(); ///< mm, new place of the vertex that moved by `distance`
};

/// Moves the vertices of each tagged cap onto the cap's plane, which goes through the cap's centroid, perpendicular to
/// its mean normal.
CapMove flatten_caps(Mesh& mesh);

/// Measures the ends, one per connected cap. Retags them 1, 2, ... by decreasing area, and returns them in this order.
std::vector<End> measure_ends(Mesh& mesh);

} // namespace anatomy
