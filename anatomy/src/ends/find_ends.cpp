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

// Mean radii: least radius of a flat part that may be an end. Bumps of a few triangles are smaller.
constexpr double smallest_radius = 0.25;
constexpr double least_off_plane = 0.03;   // mean radii: a flat part may always leave its plane by this much
constexpr double off_plane_of_noise = 0.1; // mean radii: a flat part of a rough wall may leave its plane by this much
constexpr double noise_reach = 3;   // multiple of the wall's rms roughness by which a flat part may leave its plane
constexpr double reach_of_flat = 3; // radii of a flat or open end: a point this near names the end
// Radii of a tip's last ball: a point this near to the tip names it. The ball's centre lies a radius behind the tip.
constexpr double reach_of_tip = 4;
constexpr int most_walls_shown = 12; // largest number of candidates taken for wall that are shown
constexpr double stands_out = 2; // mean radii: least prominence of a tip that may be an end, if the user names no end
constexpr double stands_out_named = 1; // mean radii: least prominence of such a tip if the user names ends

// A candidate, with the faces or the cut that make it an end.
struct Place {
  Candidate shown;
  std::vector<Face> faces; // of its cap or flat part; empty for a rounded end
  RoundedEnd rounded{};
  bool named = false; // whether a point of the user names it

  bool is_rounded() const { return faces.empty(); }
  bool is_stub() const { return !rounded.why_short.empty(); }
  // Distance from p to this place, over the largest distance at which a point names the place. Below 1, p names it.
  double distance(const Vec3& p) const {
    return is_rounded() ? (p - rounded.at).norm() / (reach_of_tip * (is_stub() ? rounded.widest : rounded.radius))
                        : (p - shown.centre).norm() / (reach_of_flat * 0.5 * shown.diameter);
  }
};

Place flat_place(const Mesh& mesh, const Tubes& tubes, const std::vector<Face>& faces, const std::string& kind,
                 bool rough) {
  const PatchPlane plane = plane_of(mesh, faces);
  Place out;
  out.faces = faces;
  out.shown.kind = kind;
  out.shown.centre = plane.centre;
  out.shown.diameter = 2 * std::sqrt(plane.area / M_PI);
  out.shown.off_plane = plane.highest - plane.lowest;
  out.shown.width = plane.width;
  out.shown.is_end = true;
  if (kind == "given") {
    out.shown.why = "given as an end";
    return out;
  }
  out.shown.evidence = tubes.evidence(faces, plane);
  const std::string why = no_end_since(plane, out.shown.evidence, rough);
  out.shown.is_end = kind == "open" || why.empty();
  out.shown.why = kind == "open" ? "an opening" : why.empty() ? "closes the vessel" : why;
  return out;
}

Place rounded_place(const RoundedEnd& end, bool is_end) {
  Place out;
  out.rounded = end;
  out.shown.kind = "rounded";
  out.shown.width = 2 * end.radius;
  out.shown.centre = end.at;
  out.shown.diameter = 2 * end.radius;
  out.shown.is_end = is_end;
  out.shown.why = end.why_short.empty() ? "the tip of a vessel" : end.why_short;
  return out;
}

void tag(Mesh& mesh, const std::vector<Face>& faces, int value) {
  RegionMap region = region_map(mesh);
  for (Face f : faces)
    region[f] = value;
}

// The tagged caps and openings as candidates. The flat parts of the wall are added, unless all ends are known to be
// tagged.
std::vector<Place> flat_places(const Mesh& mesh, const NamedEnds& named, double least_radius) {
  const Tubes tubes(mesh);
  std::vector<Place> places;
  for (const auto& [value, faces] : tagged_faces(mesh))
    places.push_back(flat_place(mesh, tubes, faces, named.openings.contains(value) ? "open" : "given", false));
  if (named.tagged)
    return places;
  const double mean = mean_radius(mesh);
  const double radius = std::max(least_radius, smallest_radius * mean);
  const double reach = noise_reach * roughness_of(mesh).rms;
  const double flat = std::clamp(reach, least_off_plane * mean, off_plane_of_noise * mean);
  for (const auto& faces : planar_patches(mesh, flat, M_PI * radius * radius))
    places.push_back(flat_place(mesh, tubes, faces, "flat", reach > flat));
  return places;
}

std::string line_of(const Candidate& one) {
  char text[160];
  std::snprintf(text, sizeof text, "%s, %s, diameter %.2f mm", place(one.centre).c_str(), one.kind.c_str(),
                one.diameter);
  return text;
}

// A list for error messages: the ends that points name if `named`, else the ends that no point names.
std::string list_of(const std::vector<Place>& places, bool named) {
  std::string text;
  for (const Place& one : places)
    if (one.shown.is_end && one.named == named)
      text += (text.empty() ? "" : "; ") + line_of(one.shown);
  return text.empty() ? "none" : text;
}

// Marks as named the end or tip nearest to p, the user's point for `option`. Throws InputError if none is near, or if
// another point names it already.
void name_nearest(const Vec3& p, const std::string& option, std::vector<Place>& places) {
  Place* best = nullptr;
  for (Place& one : places)
    if ((one.shown.is_end || one.is_rounded()) && one.distance(p) < 1 && (!best || one.distance(p) < best->distance(p)))
      best = &one;
  if (!best)
    throw InputError("no end of the vessel near the given point", option, place(p),
                     "give a point near an end, or cut the vessel there by --cut; ends found: " +
                         list_of(places, true) + "; " + list_of(places, false));
  if (best->named)
    throw InputError("two points name the same end", option, place(p) + " and another: " + line_of(best->shown),
                     "give one point near each end; ends not named: " + list_of(places, false));
  best->named = true;
}

// Makes a stub an end if the inlet's point names it, since a left main may be shorter than it is wide. The stub stays
// wall if the point is nearer to an end.
void keep_stub_at_inlet(std::vector<Place>& places, const Vec3& inlet) {
  Place* best = nullptr;
  for (Place& one : places)
    if ((one.shown.is_end || one.is_stub()) && one.distance(inlet) < 1 &&
        (!best || one.distance(inlet) < best->distance(inlet)))
      best = &one;
  if (!best || best->shown.is_end)
    return;
  best->shown.is_end = best->named = true;
  best->shown.why += ", but named";
}

// Warns of an opening that the user made an end although it is narrower than the vessel behind it. Such an end
// restricts the flow.
void warn_of_narrow(const Place& end, std::vector<Repair>& repairs) {
  if (end.shown.kind != "open" || end.shown.width >= least_width * 2 * end.shown.evidence.ball)
    return;
  char behind[128];
  std::snprintf(behind, sizeof behind, "; the vessel behind it is %.2f mm wide: cut the end where the vessel is whole",
                2 * end.shown.evidence.ball);
  repairs.push_back({"end narrower than its vessel", 1, line_of(end.shown) + behind, true});
}

// Warns of a closed end that becomes an outlet although the surface is open at two ends or more. The vessel may be
// blind there, as at an occlusion.
void warn_of_blind(const std::vector<Place>& places, std::vector<Repair>& repairs) {
  const auto open =
      std::count_if(places.begin(), places.end(), [](const Place& one) { return one.shown.kind == "open"; });
  if (open < 2)
    return;
  for (const Place& one : places)
    if (one.is_rounded() && one.shown.is_end && !one.named)
      repairs.push_back({"closed end among open ones", 1,
                         "at " + place(one.rounded.at) +
                             ": it becomes an outlet, with flow; if the vessel is blind there, name every outlet by "
                             "--outlet and leave it out",
                         true});
}

// Keeps as ends only those that the points name. If the inlet has no point, it is the largest of the other ends.
void keep_named(std::vector<Place>& places, const NamedEnds& named, std::vector<Repair>& repairs) {
  for (const Vec3& p : named.outlets)
    name_nearest(p, "--outlet", places);
  if (named.inlet)
    name_nearest(*named.inlet, "--inlet", places);
  else if (const auto largest = std::max_element(places.begin(), places.end(),
                                                 [](const Place& a, const Place& b) {
                                                   const auto size = [](const Place& one) {
                                                     return one.shown.is_end && !one.named ? one.shown.diameter : 0.0;
                                                   };
                                                   return size(a) < size(b);
                                                 });
           largest != places.end() && largest->shown.is_end && !largest->named)
    largest->named = true;
  std::string open;
  for (const Place& one : places)
    if (!one.named && one.shown.kind == "open")
      open += (open.empty() ? "" : "; ") + line_of(one.shown);
  if (!open.empty() && !named.close_others)
    throw InputError("openings of the vessel that no point names", "--inlet, --outlet",
                     "named: " + list_of(places, true) + "; not named: " + open,
                     "give a point near each, or close them by --close-others");
  for (Place& one : places) {
    if (one.named) {
      warn_of_narrow(one, repairs);
      one.shown.why += one.shown.is_end ? ", named" : ", but named";
    } else if (one.shown.is_end) {
      repairs.push_back({"end without a point left closed", 1, line_of(one.shown), true});
      one.shown.why += ", but not named";
    }
    one.shown.is_end = one.named;
  }
}

// Tags patches of wall that lie within a rough end as parts of the end. If they stayed wall, they would fold when the
// end is flattened.
void tag_islands(Mesh& mesh) {
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

std::vector<End> tagged_ends(Mesh& mesh, const std::vector<Place>& places) {
  int next = 0;
  RegionMap region = region_map(mesh);
  for (Face f : mesh.faces())
    region[f] = 0; // this also removes the patches that tag_islands tagged in an earlier call
  for (const Place& one : places)
    tag(mesh, one.faces, one.shown.is_end ? ++next : 0);
  if (std::any_of(places.begin(), places.end(), [](const Place& one) { return one.shown.kind == "flat"; }))
    tag_islands(mesh);
  return measured_ends(mesh);
}

// Cuts off the rounded rims of flat ends. The cap behind the rim is as wide as the vessel. The flat part alone would be
// too small a cap, and would narrow the flow.
void cut_rims(Mesh& mesh, std::vector<Place>& places, std::vector<Repair>& repairs) {
  std::vector<std::pair<Plane, Vertex>> cuts;
  const Slices slices(mesh);
  for (Place& one : places) {
    if (one.shown.kind != "flat" || !one.shown.is_end)
      continue;
    const PatchPlane end = plane_of(mesh, one.faces);
    if (const auto plane = plane_behind_rim(slices, end, one.shown.evidence.section)) {
      cuts.emplace_back(*plane, mesh.target(mesh.halfedge(one.faces.front())));
      one.shown.diameter = 2 * std::sqrt(slices.outline({plane->centre, plane->normal}).area / M_PI);
      one.shown.why += ", behind its rounded rim";
    }
  }
  for (const auto& [plane, vertex] : cuts)
    report_cut(repairs, "rounded rim of a flat end cut off", plane,
               cut(mesh, plane, vertex, "cut the end flat or leave it open, or cut the vessel there by --cut"));
}

// Cuts the vessel where the user asks, and adds the tags of the new caps to `named.openings`.
void cut_asked(Mesh& mesh, NamedEnds& named, double least_radius, std::vector<Repair>& repairs) {
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

std::vector<Candidate> find_ends(Mesh& mesh, NamedEnds named, double least_radius, std::vector<Repair>& repairs) {
  remove_isolated_vertices(mesh);
  mesh.collect_garbage(); // afterwards the faces' indices run from 0 without gaps
  region_map(mesh);       // tags all faces as wall if the mesh has no tags
  if (!named.cuts.empty())
    cut_asked(mesh, named, least_radius, repairs);
  std::vector<Place> places = flat_places(mesh, named, least_radius);
  const std::vector<End> ends = tagged_ends(mesh, places);
  flatten_spikes(mesh, repairs); // after tagging, since it leaves tagged caps unchanged
  const bool all_named = !named.outlets.empty();
  const bool any_named = all_named || named.inlet;
  for (const RoundedEnd& end : rounded_ends(mesh, ends, any_named ? stands_out_named : stands_out, any_named)) {
    if (!end.reached && end.why_short.empty() && !named.tagged && !all_named)
      throw InputError("no way through the lumen to a rounded end", place(end.at),
                       "it stands out by " + std::to_string(end.prominence) + " mm",
                       "cut that end flat or leave it open, name every end by points, or export a finer surface");
    places.push_back(rounded_place(end, end.why_short.empty() && !named.tagged));
  }
  if (all_named)
    keep_named(places, named, repairs);
  else if (named.inlet && !named.tagged)
    keep_stub_at_inlet(places, *named.inlet);
  warn_of_blind(places, repairs);
  for (const Place& one : places)
    if (one.is_rounded() && !one.shown.is_end && (named.tagged || one.is_stub()))
      repairs.push_back({"rounded end left closed", 1,
                         "at " + place(one.rounded.at) + ": " +
                             (named.tagged ? "the surface's caps are its ends" : one.rounded.why_short),
                         true});
  tagged_ends(mesh, places);
  cut_rims(mesh, places, repairs);
  for (const Place& one : places)
    if (one.is_rounded() && one.shown.is_end)
      cut_rounded(mesh, one.rounded, repairs);
  mesh.collect_garbage();
  cap_open_ends(mesh, repairs);
  std::vector<Candidate> shown;
  for (const Place& one : places)
    shown.push_back(one.shown);
  std::stable_sort(shown.begin(), shown.end(), [](const Candidate& a, const Candidate& b) {
    return a.is_end != b.is_end ? a.is_end : a.width > b.width;
  });
  const auto walls = std::find_if(shown.begin(), shown.end(), [](const Candidate& one) { return !one.is_end; });
  if (shown.end() - walls > most_walls_shown)
    shown.erase(walls + most_walls_shown, shown.end());
  return shown;
}

std::vector<std::vector<Face>> flat_ends(const Mesh& mesh, double least_radius) {
  std::vector<std::vector<Face>> ends;
  for (const Place& one : flat_places(mesh, {}, least_radius))
    if (one.shown.kind == "flat" && one.shown.is_end)
      ends.push_back(one.faces);
  return ends;
}

std::string table_of(const std::vector<Candidate>& candidates) {
  std::string text =
      "       x        y        z  kind     diameter  off plane  ball diameter  section mm2  tilt  verdict\n";
  for (const Candidate& one : candidates) {
    char line[320];
    std::snprintf(line, sizeof line, "%8.2f %8.2f %8.2f  %-8s %8.2f %10.3f", one.centre.x(), one.centre.y(),
                  one.centre.z(), one.kind.c_str(), one.diameter, one.off_plane);
    text += line;
    if (one.kind == "rounded")
      std::snprintf(line, sizeof line, "%15s %12s %5s", "-", "-", "-");
    else if (one.evidence.section > 0)
      std::snprintf(line, sizeof line, "%15.2f %12.2f %5.0f", 2 * one.evidence.ball, one.evidence.section,
                    one.evidence.tilt);
    else
      std::snprintf(line, sizeof line, "%15.2f %12s %5s", 2 * one.evidence.ball, "-", "-");
    text += line;
    text += std::string("  ") + (one.is_end ? "end: " : "wall: ") + one.why + "\n";
  }
  return text;
}

nlohmann::ordered_json document_of(const std::vector<Candidate>& candidates) {
  nlohmann::ordered_json document{{"schema", "vci-ends-1"}, {"candidates", nlohmann::ordered_json::array()}};
  for (const Candidate& one : candidates)
    document["candidates"].push_back({{"kind", one.kind},
                                      {"centre_mm", {one.centre.x(), one.centre.y(), one.centre.z()}},
                                      {"diameter_mm", one.diameter},
                                      {"off_plane_mm", one.off_plane},
                                      {"ball_diameter_mm", 2 * one.evidence.ball},
                                      {"section_mm2", one.evidence.section},
                                      {"is_end", one.is_end},
                                      {"why", one.why}});
  return document;
}

} // namespace anatomy
