#include "ends/find_ends.hpp"
#include "common/error.hpp"
#include "core/measures.hpp"
#include "ends/cap_open_ends.hpp"
#include "ends/cut_ends.hpp"
#include "ends/ends.hpp"
#include "ends/rims.hpp"
#include "repair/spikes.hpp"
#include <algorithm>

namespace anatomy {
namespace {
using common::InputError;

// Least radius of a flat part that may be an end, in mean radii. Bumps of a few triangles are smaller.
constexpr double smallest_end_radius = 0.25;
// A flat part may leave its plane by `noise_multiple` times the wall's rms roughness. This limit is kept between
// `least_off_plane` and `largest_off_plane` mean radii.
constexpr double least_off_plane = 0.03;
constexpr double largest_off_plane = 0.1;
constexpr double noise_multiple = 3;
constexpr double flat_naming_radii = 3; // a point within this many radii of a flat or open end's centre names the end
// A point this near to a tip (in radii of the tip's last sphere) names the tip. The sphere's centre lies a radius
// behind it.
constexpr double tip_naming_radii = 4;
constexpr int most_walls_shown = 12;           // largest number of candidates taken for wall that are shown
constexpr double least_prominence_unnamed = 2; // a tip as prominent as this (in mean radii) is an end even if unnamed

// A candidate's kind as `lumen check` and its JSON document name it.
const char* text_of(CandidateKind kind) {
  switch (kind) {
  case CandidateKind::open:
    return "open";
  case CandidateKind::given:
    return "given";
  case CandidateKind::flat:
    return "flat";
  case CandidateKind::rounded:
    break;
  }
  return "rounded";
}

// A candidate, with the faces or the cut that make it an end.
struct CandidatePlace {
  EndCandidate candidate;
  std::vector<Face> faces; // faces of its cap or flat part; empty for a rounded end
  RoundedEnd rounded{};
  bool named = false; // whether one of the user's points names this place

  bool is_rounded() const { return faces.empty(); }
  bool is_stub() const { return !rounded.too_short_reason.empty(); }
  // Distance from p to this place, as a share of the largest distance at which a point names it. Below 1, p names it.
  double distance(const Vec3& p) const {
    return is_rounded() ? (p - rounded.position).norm() /
                              (tip_naming_radii * (is_stub() ? rounded.widest_sphere : rounded.radius))
                        : (p - candidate.centre).norm() / (flat_naming_radii * 0.5 * candidate.diameter);
  }
};

CandidatePlace flat_place(const Mesh& mesh, const VesselProbe& probe, const std::vector<Face>& faces,
                          CandidateKind kind, bool rough) {
  const PatchPlane plane = plane_of(mesh, faces);
  CandidatePlace out;
  out.faces = faces;
  out.candidate.kind = kind;
  out.candidate.centre = plane.centre;
  out.candidate.diameter = 2 * std::sqrt(plane.area / pi);
  out.candidate.off_plane = plane.highest - plane.lowest;
  out.candidate.width = plane.width;
  out.candidate.is_end = true;
  if (kind == CandidateKind::given) {
    out.candidate.why = "given as an end";
    return out;
  }
  out.candidate.evidence = probe.evidence(faces, plane);
  const std::string why = no_end_reason(plane, out.candidate.evidence, rough);
  out.candidate.is_end = kind == CandidateKind::open || why.empty();
  out.candidate.why = kind == CandidateKind::open ? "an opening" : why.empty() ? "closes the vessel" : why;
  return out;
}

CandidatePlace rounded_place(const RoundedEnd& end, bool is_end) {
  CandidatePlace out;
  out.rounded = end;
  out.candidate.kind = CandidateKind::rounded;
  out.candidate.width = 2 * end.radius;
  out.candidate.centre = end.position;
  out.candidate.diameter = 2 * end.radius;
  out.candidate.is_end = is_end;
  out.candidate.why = end.too_short_reason.empty() ? "the tip of a vessel" : end.too_short_reason;
  return out;
}

void tag(Mesh& mesh, const std::vector<Face>& faces, int value) {
  RegionMap region = region_map(mesh);
  for (Face f : faces)
    region[f] = value;
}

// The tagged caps and openings as candidates. The flat parts of the wall are added, unless all ends are known to be
// tagged.
std::vector<CandidatePlace> flat_places(const Mesh& mesh, const NamedEnds& named, double least_radius) {
  const VesselProbe probe(mesh);
  std::vector<CandidatePlace> places;
  for (const auto& [value, faces] : tagged_faces(mesh))
    places.push_back(flat_place(mesh, probe, faces,
                                named.openings.contains(value) ? CandidateKind::open : CandidateKind::given, false));
  if (named.tagged)
    return places;
  const double mean = mean_radius(mesh);
  const double radius = std::max(least_radius, smallest_end_radius * mean);
  const double reach = noise_multiple * roughness_of(mesh).rms;
  const double flat = std::clamp(reach, least_off_plane * mean, largest_off_plane * mean);
  for (const auto& faces : planar_patches(mesh, flat, pi * radius * radius))
    places.push_back(flat_place(mesh, probe, faces, CandidateKind::flat, reach > flat));
  return places;
}

std::string candidate_line(const EndCandidate& one) {
  char text[160];
  std::snprintf(text, sizeof text, "%s, %s, diameter %.2f mm", point_text(one.centre).c_str(), text_of(one.kind),
                one.diameter);
  return text;
}

// A list for error messages: the ends that points name if `named`, else the ends that no point names.
std::string list_places(const std::vector<CandidatePlace>& places, bool named) {
  std::string text;
  for (const CandidatePlace& one : places)
    if (one.candidate.is_end && one.named == named)
      text += (text.empty() ? "" : "; ") + candidate_line(one.candidate);
  return text.empty() ? "none" : text;
}

// Marks as named the end or tip nearest to p, the user's point for `option`. Throws InputError if none is near, or if
// another point names it already.
void name_nearest(const Vec3& p, const std::string& option, std::vector<CandidatePlace>& places) {
  CandidatePlace* best = nullptr;
  for (CandidatePlace& one : places)
    if ((one.candidate.is_end || one.is_rounded()) && one.distance(p) < 1 &&
        (!best || one.distance(p) < best->distance(p)))
      best = &one;
  if (!best)
    throw InputError("no end of the vessel near the given point", option, point_text(p),
                     "give a point near an end, or cut the vessel there by --cut; ends found: " +
                         list_places(places, true) + "; " + list_places(places, false));
  if (best->named)
    throw InputError("two points name the same end", option,
                     point_text(p) + " and another: " + candidate_line(best->candidate),
                     "give one point near each end; ends not named: " + list_places(places, false));
  best->named = true;
}

// Makes a stub an end if the inlet's point names it, since a left main may be shorter than it is wide. The stub stays
// wall if the point is nearer to an end.
void keep_stub_at_inlet(std::vector<CandidatePlace>& places, const Vec3& inlet) {
  CandidatePlace* best = nullptr;
  for (CandidatePlace& one : places)
    if ((one.candidate.is_end || one.is_stub()) && one.distance(inlet) < 1 &&
        (!best || one.distance(inlet) < best->distance(inlet)))
      best = &one;
  if (!best || best->candidate.is_end)
    return;
  best->candidate.is_end = best->named = true;
  best->candidate.why += ", but named";
}

// Warns of an opening that the user made an end although it is narrower than the vessel behind it. Such an end
// restricts the flow.
void warn_of_narrow_end(const CandidatePlace& end, std::vector<Repair>& repairs) {
  if (end.candidate.kind != CandidateKind::open ||
      end.candidate.width >= least_width * 2 * end.candidate.evidence.sphere_radius)
    return;
  char behind[128];
  std::snprintf(behind, sizeof behind, "; the vessel behind it is %.2f mm wide: cut the end where the vessel is whole",
                2 * end.candidate.evidence.sphere_radius);
  repairs.push_back({"end narrower than its vessel", 1, candidate_line(end.candidate) + behind, true});
}

// Warns of a closed end that becomes an outlet although the surface is open at two ends or more. The vessel may end
// blindly there, as at an occlusion.
void warn_of_closed_ends(const std::vector<CandidatePlace>& places, std::vector<Repair>& repairs) {
  const auto open = std::count_if(places.begin(), places.end(),
                                  [](const CandidatePlace& one) { return one.candidate.kind == CandidateKind::open; });
  if (open < 2)
    return;
  for (const CandidatePlace& one : places)
    if (one.is_rounded() && one.candidate.is_end && !one.named)
      repairs.push_back({"closed end among open ones", 1,
                         "at " + point_text(one.rounded.position) +
                             ": it becomes an outlet, with flow; if the vessel is blind there, name every outlet by "
                             "--outlet and leave it out",
                         true});
}

// Keeps as ends only those that the points name. If the inlet has no point, it is the largest of the other ends.
void keep_named_ends(std::vector<CandidatePlace>& places, const NamedEnds& named, std::vector<Repair>& repairs) {
  for (const Vec3& p : named.outlets)
    name_nearest(p, "--outlet", places);
  if (named.inlet)
    name_nearest(*named.inlet, "--inlet", places);
  else if (const auto largest = std::max_element(places.begin(), places.end(),
                                                 [](const CandidatePlace& a, const CandidatePlace& b) {
                                                   const auto size = [](const CandidatePlace& one) {
                                                     return one.candidate.is_end && !one.named ? one.candidate.diameter
                                                                                               : 0.0;
                                                   };
                                                   return size(a) < size(b);
                                                 });
           largest != places.end() && largest->candidate.is_end && !largest->named)
    largest->named = true;
  std::string open;
  for (const CandidatePlace& one : places)
    if (!one.named && one.candidate.kind == CandidateKind::open)
      open += (open.empty() ? "" : "; ") + candidate_line(one.candidate);
  if (!open.empty() && !named.close_others)
    throw InputError("openings of the vessel that no point names", "--inlet, --outlet",
                     "named: " + list_places(places, true) + "; not named: " + open,
                     "give a point near each, or close them by --close-others");
  for (CandidatePlace& one : places) {
    if (one.named) {
      warn_of_narrow_end(one, repairs);
      one.candidate.why += one.candidate.is_end ? ", named" : ", but named";
    } else if (one.candidate.is_end) {
      repairs.push_back({"end without a point left closed", 1, candidate_line(one.candidate), true});
      one.candidate.why += ", but not named";
    }
    one.candidate.is_end = one.named;
  }
}

// Tags patches of wall that lie within a rough end as parts of the end. If they stayed wall, they would fold when the
// end is flattened.
void tag_wall_islands(Mesh& mesh) {
  RegionMap region = region_map(mesh);
  std::vector<bool> seen(mesh.number_of_faces());
  std::vector<std::vector<Face>> parts;
  for (Face seed : mesh.faces()) {
    if (seen[seed] || region[seed] != 0)
      continue;
    std::vector<Face> part{seed};
    seen[seed] = true;
    for (std::size_t i = 0; i < part.size(); ++i)
      for (Face g : mesh.faces_around_face(mesh.halfedge(part[i])))
        if (!seen[g] && region[g] == 0) {
          seen[g] = true;
          part.push_back(g);
        }
    parts.push_back(std::move(part));
  }
  const auto wall =
      std::max_element(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
  for (auto part = parts.begin(); part != parts.end(); ++part) {
    if (part == wall)
      continue;
    int around = 0;
    for (Face f : *part)
      for (Face g : mesh.faces_around_face(mesh.halfedge(f)))
        around = std::max(around, region[g]);
    tag(mesh, *part, around);
  }
}

std::vector<End> tagged_ends(Mesh& mesh, const std::vector<CandidatePlace>& places) {
  int next = 0;
  RegionMap region = region_map(mesh);
  for (Face f : mesh.faces())
    region[f] = 0; // this also removes the patches that tag_wall_islands tagged in an earlier call
  for (const CandidatePlace& one : places)
    tag(mesh, one.faces, one.candidate.is_end ? ++next : 0);
  if (std::any_of(places.begin(), places.end(),
                  [](const CandidatePlace& one) { return one.candidate.kind == CandidateKind::flat; }))
    tag_wall_islands(mesh);
  return measure_ends(mesh);
}

// Cuts off the rounded rims of flat ends. The cap behind the rim is as wide as the vessel. The flat part alone would be
// too small a cap, and would narrow the flow.
void cut_rims(Mesh& mesh, std::vector<CandidatePlace>& places, std::vector<Repair>& repairs) {
  std::vector<std::pair<Plane, Vertex>> cuts;
  const Slices slices(mesh);
  for (CandidatePlace& one : places) {
    if (one.candidate.kind != CandidateKind::flat || !one.candidate.is_end)
      continue;
    const PatchPlane end = plane_of(mesh, one.faces);
    if (const auto plane = plane_behind_rim(slices, end)) {
      cuts.emplace_back(*plane, mesh.target(mesh.halfedge(one.faces.front())));
      one.candidate.diameter = 2 * std::sqrt(slices.section_size({plane->centre, plane->normal}).area / pi);
      one.candidate.why += ", behind its rounded rim";
    }
  }
  for (const auto& [plane, vertex] : cuts)
    report_cut(
        repairs, "rounded rim of a flat end cut off", plane,
        cut_at_plane(mesh, plane, vertex, "cut the end flat or leave it open, or cut the vessel there by --cut"));
}

// Cuts the vessel where the user asks, and adds the tags of the new caps to `named.openings`.
void cut_where_asked(Mesh& mesh, NamedEnds& named, double least_radius, std::vector<Repair>& repairs) {
  Mesh tagged = mesh;
  const std::vector<End> ends = tagged_ends(tagged, flat_places(mesh, named, least_radius));
  std::set<int> known;
  for (const auto& [value, faces] : tagged_faces(mesh))
    known.insert(value);
  cut_across(mesh, tagged, ends, named.cuts, repairs);
  cap_open_ends(mesh, repairs);
  remove_isolated_vertices(mesh);
  mesh.collect_garbage();
  for (const auto& [value, faces] : tagged_faces(mesh))
    if (!known.contains(value))
      named.openings.insert(value);
}

} // namespace

std::vector<EndCandidate> find_ends(Mesh& mesh, NamedEnds named, double least_radius, std::vector<Repair>& repairs) {
  remove_isolated_vertices(mesh);
  mesh.collect_garbage(); // afterwards the faces' indices run from 0 without gaps
  region_map(mesh);       // tags all faces as wall if the mesh has no tags
  if (!named.cuts.empty())
    cut_where_asked(mesh, named, least_radius, repairs);
  std::vector<CandidatePlace> places = flat_places(mesh, named, least_radius);
  const std::vector<End> ends = tagged_ends(mesh, places);
  flatten_spikes(mesh, repairs); // after tagging, since it leaves tagged caps unchanged
  const bool all_named = !named.outlets.empty();
  const bool any_named = all_named || named.inlet;
  for (const RoundedEnd& end :
       rounded_ends(mesh, ends, any_named ? least_stub_prominence : least_prominence_unnamed, any_named)) {
    if (!end.is_reachable && end.too_short_reason.empty() && !named.tagged && !all_named)
      throw InputError("no way through the lumen to a rounded end", point_text(end.position),
                       "it stands out by " + std::to_string(end.prominence) + " mm",
                       "cut that end flat or leave it open, name every end by points, or export a finer surface");
    places.push_back(rounded_place(end, end.too_short_reason.empty() && !named.tagged));
  }
  if (all_named)
    keep_named_ends(places, named, repairs);
  else if (named.inlet && !named.tagged)
    keep_stub_at_inlet(places, *named.inlet);
  warn_of_closed_ends(places, repairs);
  for (const CandidatePlace& one : places)
    if (one.is_rounded() && !one.candidate.is_end && (named.tagged || one.is_stub()))
      repairs.push_back(
          {"rounded end left closed", 1,
           "at " + point_text(one.rounded.position) + ": " +
               (named.tagged ? "the surface's caps are its ends" : one.rounded.too_short_reason + "; " + stub_remedy),
           true});
  tagged_ends(mesh, places);
  cut_rims(mesh, places, repairs);
  for (const CandidatePlace& one : places)
    if (one.is_rounded() && one.candidate.is_end)
      cut_rounded(mesh, one.rounded, repairs);
  mesh.collect_garbage();
  cap_open_ends(mesh, repairs);
  std::vector<EndCandidate> candidates;
  for (const CandidatePlace& one : places)
    candidates.push_back(one.candidate);
  std::stable_sort(candidates.begin(), candidates.end(), [](const EndCandidate& a, const EndCandidate& b) {
    return a.is_end != b.is_end ? a.is_end : a.width > b.width;
  });
  const auto walls =
      std::find_if(candidates.begin(), candidates.end(), [](const EndCandidate& one) { return !one.is_end; });
  if (candidates.end() - walls > most_walls_shown)
    candidates.erase(walls + most_walls_shown, candidates.end());
  return candidates;
}

std::vector<std::vector<Face>> flat_ends(const Mesh& mesh, double least_radius) {
  std::vector<std::vector<Face>> ends;
  for (const CandidatePlace& one : flat_places(mesh, {}, least_radius))
    if (one.candidate.kind == CandidateKind::flat && one.candidate.is_end)
      ends.push_back(one.faces);
  return ends;
}

std::string table_of(const std::vector<EndCandidate>& candidates) {
  std::string text =
      "       x        y        z  kind     diameter  off plane  ball diameter  section mm2  tilt  verdict\n";
  for (const EndCandidate& one : candidates) {
    char line[320];
    std::snprintf(line, sizeof line, "%8.2f %8.2f %8.2f  %-8s %8.2f %10.3f", one.centre.x(), one.centre.y(),
                  one.centre.z(), text_of(one.kind), one.diameter, one.off_plane);
    text += line;
    if (one.kind == CandidateKind::rounded)
      std::snprintf(line, sizeof line, "%15s %12s %5s", "-", "-", "-");
    else if (one.evidence.section.area > 0)
      std::snprintf(line, sizeof line, "%15.2f %12.2f %5.0f", 2 * one.evidence.sphere_radius, one.evidence.section.area,
                    one.evidence.tilt);
    else
      std::snprintf(line, sizeof line, "%15.2f %12s %5s", 2 * one.evidence.sphere_radius, "-", "-");
    text += line;
    text += std::string("  ") + (one.is_end ? "end: " : "wall: ") + one.why + "\n";
  }
  return text;
}

nlohmann::ordered_json document_of(const std::vector<EndCandidate>& candidates) {
  nlohmann::ordered_json document{{"schema", "vci-ends-1"}, {"candidates", nlohmann::ordered_json::array()}};
  for (const EndCandidate& one : candidates)
    document["candidates"].push_back({{"kind", text_of(one.kind)},
                                      {"centre_mm", {one.centre.x(), one.centre.y(), one.centre.z()}},
                                      {"diameter_mm", one.diameter},
                                      {"off_plane_mm", one.off_plane},
                                      {"ball_diameter_mm", 2 * one.evidence.sphere_radius},
                                      {"section_mm2", one.evidence.section.area},
                                      {"is_end", one.is_end},
                                      {"why", one.why}});
  return document;
}

} // namespace anatomy
