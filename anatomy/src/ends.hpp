// The flat ends of the lumen: found, flattened, measured, and named once the tree is known.
#pragma once
#include "ragged_ends.hpp"
#include "types.hpp"
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

namespace anatomy {

/// Closes every open end with a flat cap (its rim is moved onto its least-squares plane first) and tags the cap's faces
/// 1, 2, ... after the regions in use. Rims that this would crumple are closed as they are, without a tag. Returns what
/// cut_ragged needs. Throws InputError if a rim is too ragged for that, or cannot be closed.
std::vector<OpenEnd> cap_open_ends(Mesh& mesh, std::vector<Repair>& repairs);

/// Tags the flat end caps of a closed mesh by shape: planar patches (within 12 degrees and 3 % of their size), round,
/// from whose rim the wall leaves along the normal, and of at least this radius (mm). A patch already tagged is left
/// alone.
void tag_flat_caps(Mesh& mesh, double least_radius = 0);

/// Tags faces with the soup's region_id, by the nearest triangle of the soup.
void tag_from_soup(Mesh& mesh, const Soup& soup);

/// Tags as wall what is apart from a larger cap of the same tag and below smallest_end in radius, as the removal of
/// self-intersections leaves beside a rim; of the tags `single`, which one cap each has, whatever its radius.
void drop_scraps_of_caps(Mesh& mesh, const std::set<int>& single, std::vector<Repair>& repairs);

/// How far the largest move went, and where to.
struct Move {
  double distance = 0; ///< mm
  Vec3 to = Vec3::Zero();
};

/// Moves the vertices of each tagged cap onto the cap's plane; returns the largest move.
Move flatten_caps(Mesh& mesh);

/// The ends by their tags, one per connected cap; retags them 1, 2, ... by falling area.
std::vector<End> measured_ends(Mesh& mesh);

/// Index of the inlet: nearest to `inlet` if given, else the largest. Throws InputError if the point is farther than
/// three radii from every end, or if there are fewer than two ends.
std::size_t inlet_of(const std::vector<End>& ends, const std::optional<Vec3>& inlet);

/// Which end is the inlet, and the branch id of each end (0 main, 1 side1, ...; the inlet's is -1).
struct Naming {
  std::size_t inlet = 0;
  std::vector<int> branch; ///< empty: the tree decides
};

/// The naming of an earlier state (anatomy.json), each end matched to the nearest one of that state, whose extension
/// it takes. Throws InputError if the number differs or two ends match the same one.
Naming naming_like(std::vector<End>& ends, const nlohmann::json& like);

/// The inlet as by inlet_of; with `outlets` the outlets in the order of the points (the first is main's). Throws
/// InputError if a point is not near an end, or if not each outlet has one point.
Naming naming_given(const std::vector<End>& ends, const std::optional<Vec3>& inlet, const std::vector<Vec3>& outlets);

} // namespace anatomy
