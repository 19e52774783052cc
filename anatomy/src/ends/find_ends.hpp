// Finds which places of a closed surface are the vessel's ends, and says why.
#pragma once
#include "ends/evidence.hpp"
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

namespace anatomy {

/// Least prominence of a tip that counts as a stub, in mean radii. A stub is wall unless the user names it as an end.
constexpr double least_stub_prominence = 0.4;
/// What a user can do about a stub that is left closed.
inline const std::string stub_remedy =
    "if it is a branch, cut it flat or open it in the surface, or name it among all outlets by --outlet";

/// What the user says about the ends.
struct NamedEnds {
  std::optional<Vec3> inlet; ///< mm, a point near the inlet
  std::vector<Vec3> outlets; ///< mm, points near the outlets; if any are given, there are no other outlets
  std::vector<Vec3> cuts;    ///< mm, points near which the vessel is cut across before ends are sought
  std::set<int> openings;    ///< tags of the caps that closed openings of the surface
  bool tagged = false;       ///< whether all ends already have tags, from cap files or the surface's own region_id
  bool close_others = false; ///< whether openings without a point are closed and become wall
};

/// What a candidate for an end is on the surface.
enum class CandidateKind {
  open,   ///< an opening
  given,  ///< already tagged
  flat,   ///< a flat part of the wall
  rounded ///< a vessel's tip
};

/// A place where the vessel may end, as the user sees it.
struct EndCandidate {
  CandidateKind kind = CandidateKind::flat;
  Vec3 centre = Vec3::Zero();
  double diameter = 0;  ///< mm, of a disc of the same area; for a rounded end the diameter of the vessel's last sphere
  double width = 0;     ///< mm, minor axis (see PatchPlane); for a rounded end the same as `diameter`
  double off_plane = 0; ///< mm along the normal from the innermost to the outermost vertex; 0 for a rounded end
  EndEvidence evidence; ///< measured at open and flat places only
  bool is_end = false;
  std::string why; ///< reason for the decision
};

/// Tags the ends of a closed mesh and cuts rounded ends flat. The caps of open ends are tagged already.
/// - If no outlets are named, the ends are every opening, every flat part that closes the vessel, and every rounded tip
///   of a vessel (evidence.hpp, cut_ends.hpp).
/// - If outlets are named, these and the inlet are the only ends, and all other places become wall. Without a named
///   inlet, the largest other end is the inlet.
/// - If `named.tagged`, no flat parts are sought, and rounded tips stay closed unless a point names them.
/// `least_radius` (mm) is the smallest radius of a flat end. Returns the candidates: first the ends, then the widest of
/// those taken for wall. Throws InputError if nothing ends near a point, if two points name the same end, or if an
/// opening has no point. It also throws if a rounded end has no axis or cannot be cut flat.
std::vector<EndCandidate> find_ends(Mesh& mesh, NamedEnds named, double least_radius, std::vector<Repair>& repairs);

/// The faces of each untagged flat part of a closed mesh that closes a vessel of at least this radius (mm).
std::vector<std::vector<Face>> flat_ends(const Mesh& mesh, double least_radius);

/// The candidates as a table of text for `lumen check`, and as the JSON document that `anatomy ends` draws.
std::string table_of(const std::vector<EndCandidate>& candidates);
nlohmann::ordered_json document_of(const std::vector<EndCandidate>& candidates);

} // namespace anatomy
