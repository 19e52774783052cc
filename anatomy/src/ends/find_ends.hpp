// Which places of a closed surface are the vessel's ends, and why.
#pragma once
#include "ends/evidence.hpp"
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

namespace anatomy {

/// The ends as the user names them.
struct NamedEnds {
  std::optional<Vec3> inlet; ///< mm
  std::vector<Vec3> outlets; ///< mm; if any are given, the vessel has no others
  std::vector<Vec3> cuts;    ///< mm, where the vessel is cut across first
  std::set<int> openings;    ///< tags of the caps that closed openings of the surface
  bool tagged = false;       ///< all ends are tagged already, by cap files or by the surface's own region_id
  bool close_others = false; ///< openings without a point are closed: wall
};

/// A place where the vessel may end, for the user to see.
struct Candidate {
  std::string kind; ///< open, given, flat or rounded
  Vec3 centre = Vec3::Zero();
  double diameter = 0;  ///< mm, of a disc of its area; for a rounded one, of the vessel's last ball
  double width = 0;     ///< mm, as in PatchPlane
  double off_plane = 0; ///< mm between its vertices nearest to and farthest from the vessel
  Evidence evidence;    ///< for flat ones
  bool is_end = false;
  std::string why;
};

/// Tags the ends of a closed mesh and cuts rounded ones flat. Open ends are tagged already.
/// - Without names the ends are every opening, every flat part that closes the tube (evidence.hpp), and every rounded
///   tip of a vessel.
/// - With names exactly the named ones are ends, and the others are wall.
/// Returns the candidates: the ends first, then the widest of those taken for wall. Throws InputError if nothing ends
/// near a point, if two points name the same end, if an opening has no point, or if a rounded end cannot be cut flat.
std::vector<Candidate> find_ends(Mesh& mesh, NamedEnds named, double least_radius, std::vector<Repair>& repairs);

/// The untagged flat parts of a closed mesh that close a tube of this radius (mm) or a wider one.
std::vector<std::vector<Face>> flat_ends(const Mesh& mesh, double least_radius);

/// The candidates as a table for people, and as a document for the picture.
std::string table_of(const std::vector<Candidate>& candidates);
nlohmann::ordered_json document_of(const std::vector<Candidate>& candidates);

} // namespace anatomy
