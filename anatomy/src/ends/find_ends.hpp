// Which places of a closed surface are the vessel's ends, and why.
#pragma once
#include "ends/evidence.hpp"
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

namespace anatomy {

/// What the user says of the ends.
struct NamedEnds {
  std::optional<Vec3> inlet;
  std::vector<Vec3> outlets; ///< mm; where there are any they are all there are
  std::vector<Vec3> cuts;    ///< mm, where the vessel is cut across first
  std::set<int> openings;    ///< tags of what was open
  bool tagged = false;       ///< all ends are tagged already, by cap files or by the surface's own region_id
  bool close_others = false; ///< openings without a point are closed: wall
};

/// A place where the vessel may end, for the user to see.
struct Candidate {
  std::string kind; ///< open, given, flat or rounded
  Vec3 centre = Vec3::Zero();
  double diameter = 0;  ///< mm, of a disc of its area; of a rounded one that of the vessel's last ball
  double width = 0;     ///< mm, as of PatchPlane
  double off_plane = 0; ///< mm between its vertices nearest to and farthest from the vessel
  Evidence evidence;    ///< of flat ones
  bool is_end = false;
  std::string why;
};

/// Tags the ends of a closed mesh and cuts rounded ones flat. Open ends are tagged already.
/// - Without names the ends are every opening, every flat part that closes the tube (evidence.hpp), and every rounded
///   tip of a vessel.
/// - With names exactly the named ones are ends, and the others are wall.
/// Returns the candidates: the ends first, then the widest of those taken for wall. Throws InputError where nothing
/// ends near a point, where two points name the same end, or where an opening has no point.
std::vector<Candidate> find_ends(Mesh& mesh, NamedEnds named, double least_radius, std::vector<Repair>& repairs);

/// The untagged flat parts of a closed mesh that close a tube of this radius (mm) or a wider one.
std::vector<std::vector<Face>> flat_ends(const Mesh& mesh, double least_radius);

/// The candidates as a table for people, and as a document for the picture.
std::string table_of(const std::vector<Candidate>& candidates);
nlohmann::ordered_json document_of(const std::vector<Candidate>& candidates);

} // namespace anatomy
