#include "app/checks.hpp"
#include "common/error.hpp"
#include "core/measures.hpp"
#include "ends/cut_ends.hpp"
#include "repair/spikes.hpp"
#include "repair/tips.hpp"
#include <algorithm>

namespace anatomy {
namespace {

using common::InputError;

constexpr double least_reported_move = 1e-3; // mm; a smaller move of the caps is not reported
// A larger move of a cap (in its radii) gives a warning. A move of 0.1 is a tilt of 6 degrees, which changes the area
// by half a per cent.
constexpr double most_unwarned_move = 0.1;
constexpr double least_good_angle = 30; // a smaller angle of a triangle (degrees) gives a warning
// If the wall's rms scatter reaches this (in mean edge lengths), ends may be missed. Flat ends are found until noise
// tilts the triangles by about 12 degrees.
constexpr double rough_scatter = 0.15;
constexpr double least_wide_stub = 1; // least prominence of a stub that may be the inlet, in mean radii
constexpr double rim_radii = 2;       // a tip farther from an end's centre (in its radii) is not at the end's rim
// A closed branch that stands out by more than this (in its radii) is a tube. A sac is as wide as it is long.
constexpr double tube_prominence = 1.5;
constexpr double narrowest_stub = 0.3; // mm, radius of the narrowest closed branch that is checked

// Whether p (mm) is at the rim of no end.
bool is_away_from_ends(const Vec3& p, const std::vector<End>& ends) {
  return std::all_of(ends.begin(), ends.end(),
                     [&](const End& end) { return (end.centre - p).norm() > rim_radii * end.radius(); });
}

} // namespace

void check_no_handle(Mesh& mesh, long most_handles) {
  remove_isolated_vertices(mesh);
  mesh.collect_garbage();
  const auto places = places_on_handles(mesh);
  if (places.empty())
    return;
  const long euler =
      static_cast<long>(mesh.number_of_vertices() + mesh.number_of_faces()) - static_cast<long>(mesh.number_of_edges());
  if (euler > 2)
    throw InputError("the surface falls into pieces", "near " + point_text(vec(mesh.point(places[0]))),
                     "Euler number " + std::to_string(euler), "smooth or re-segment the surface there");
  const long rings = 1 - euler / 2;
  if (rings <= most_handles)
    return;
  throw InputError(rings > 1 ? "the lumen forms " + std::to_string(rings) + " rings, as no coronary tree does"
                             : "the lumen forms a ring, as no coronary tree does",
                   "near " + point_text(vec(mesh.point(places[0]))), "Euler number " + std::to_string(euler),
                   rings > most_touching_rings
                       ? "smooth or re-segment the surface: so many are noise as large as its triangles"
                       : "separate the vessels that touch there, or fill the hole through the lumen");
}

void check_no_stub(const Mesh& mesh, const std::vector<End>& ends, bool all_named, std::vector<Repair>& repairs) {
  for (const RoundedEnd& end : rounded_ends(mesh, ends, least_stub_prominence, true)) {
    if (end.widest_sphere < narrowest_stub || end.prominence < end.widest_sphere)
      continue;
    char value[160];
    std::snprintf(value, sizeof value, "diameter %.2f mm, closed, stands out by %.2f mm", 2 * end.widest_sphere,
                  end.prominence);
    if (!all_named && end.prominence > tube_prominence * end.widest_sphere)
      throw InputError("a branch of the coronary tree without an end", "at " + point_text(end.position), value,
                       "cut it flat or open it, or cut across it by --cut x,y,z; to leave it closed name every outlet "
                       "by --outlet");
    repairs.push_back({"branch left closed", 1, "at " + point_text(end.position) + ", " + value, true});
  }
}

void check_no_wide_stub(const Mesh& mesh, const std::vector<End>& ends) {
  double widest = 0; // mm, radius of the widest end
  for (const End& end : ends)
    widest = std::max(widest, end.radius());
  for (const RoundedEnd& stub : rounded_ends(mesh, ends, least_wide_stub, true)) {
    if (stub.widest_sphere <= widest)
      continue;
    char value[160];
    std::snprintf(value, sizeof value, "%.2f mm wide, stands out by %.2f mm; the widest end has %.2f mm",
                  2 * stub.widest_sphere, stub.prominence, 2 * widest);
    throw InputError(
        "a closed stub is wider than every end: where does blood enter?", "at " + point_text(stub.position), value,
        "name the inlet by --inlet x,y,z, at the stub's tip or, if the stub is an aneurysm, at the end where blood "
        "enters; or cut the stub flat or open it");
  }
}

void warn_of_stubs(const Mesh& mesh, const std::vector<End>& ends, const std::vector<EndCandidate>& candidates,
                   std::vector<Repair>& repairs) {
  const double mean = mean_radius(mesh);
  std::vector<Vec3> warned_tips; // tips that have a warning, from the search for the ends or from this function
  for (const EndCandidate& one : candidates)
    if (one.kind == CandidateKind::rounded)
      warned_tips.push_back(one.centre);
  for (const Tip& tip : tips_beside_ends(mesh, ends, least_stub_prominence * mean)) {
    const Vec3 at = vec(mesh.point(tip.vertex));
    if (tip.is_extremity && is_away_from_ends(at, ends)) {
      char value[80];
      std::snprintf(value, sizeof value, "%.1f mm along the wall from the other extremity", tip.prominence);
      throw InputError("the lumen goes on beyond its ends", "to " + point_text(at), value,
                       "cut it flat or open it there, or cut across it by --cut x,y,z; to leave it closed name every "
                       "outlet by --outlet");
    }
    if (std::any_of(warned_tips.begin(), warned_tips.end(), [&](const Vec3& p) { return (p - at).norm() < mean; }))
      continue;
    warned_tips.push_back(at);
    char detail[120];
    std::snprintf(detail, sizeof detail, "at %s: it stands out by %.2f mm and counts as wall; ", point_text(at).c_str(),
                  tip.prominence);
    repairs.push_back({"stub left closed", 1, detail + stub_remedy, true});
  }
}

std::vector<Vec3> stub_tips(const Mesh& mesh, const std::vector<End>& ends) {
  std::vector<Vec3> out;
  for (const Tip& tip : tips_beside_ends(mesh, ends, least_stub_prominence * mean_radius(mesh)))
    if (const Vec3 at = vec(mesh.point(tip.vertex)); is_away_from_ends(at, ends))
      out.push_back(at);
  return out;
}

void report_cap_move(std::vector<Repair>& repairs, const CapMove& move, std::size_t ends) {
  if (move.distance > least_reported_move)
    repairs.push_back({"caps flattened", ends,
                       "moved up to " + std::to_string(move.distance) + " mm at " + point_text(move.moved_to),
                       move.share > most_unwarned_move});
}

void warn_of_small_angle(std::vector<Repair>& repairs, const Quality& quality) {
  if (quality.min_angle_deg >= least_good_angle)
    return;
  char detail[160];
  std::snprintf(detail, sizeof detail,
                "of %.1f degrees at %s: %.0f are wanted. The surface can be used; another --edge may do better",
                quality.min_angle_deg, point_text(quality.min_angle_at).c_str(), least_good_angle);
  repairs.push_back({"narrow corner in the new surface", 1, detail, true});
}

void check_ends_seen(const Mesh& mesh, const std::vector<End>& ends) {
  const Roughness wall = roughness_of(mesh);
  if (ends.size() >= 2 || wall.rms < rough_scatter * wall.edge)
    return;
  char value[160];
  std::snprintf(value, sizeof value, "%zu ends found; the wall scatters by %.3f mm (rms) at edges of %.3f mm",
                ends.size(), wall.rms, wall.edge);
  throw InputError("the wall is too rough for its ends to be seen", "roughest near " + point_text(wall.at), value,
                   "smooth the surface, or cut its ends off and leave them open");
}

} // namespace anatomy
