#include "ends/cut_ends.hpp"
#include "centreline/sphere_path.hpp"
#include "common/error.hpp"
#include "core/measures.hpp"
#include "core/slices.hpp"
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <algorithm>

namespace anatomy {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using common::InputError;

constexpr double least_prominence = 2; // a tip of less prominence (in mean radii) is a stub without an end of its own
// Least prominence of a vessel with an end, in radii of its last sphere. A sac is as wide as long, and has less.
constexpr double least_sphere_prominence = 3;
// Distance from the last sphere's centre to the first plane that is tried, and from a plane to the section it is
// compared with, in radii. Even if the first plane is tilted by 26 degrees, it meets the wall behind the centre.
constexpr double behind_sphere_radii = 0.5;
constexpr double plane_step_radii = 0.25; // distance between the planes that are tried, in sphere radii
// Largest ratio of the radii of two inscribed spheres one radius apart along the axis. Where the ratio is larger the
// tip still tapers, and no cut is made.
constexpr double tip_taper_ratio = 1.15;
// Two sections half a radius apart count as alike up to this ratio of their areas. It is a taper of 12 degrees on each
// side.
constexpr double similar_area_ratio = 1.25;
// A tip less than this (in radii of the end) beyond the farthest point of an end's rim belongs to the rim.
constexpr double rim_margin_radii = 0.4;
// Two spheres are about equally near to a tip if their gaps to it differ by less than this (in sphere radii).
constexpr double equal_gap_radii = 0.1;
// Largest gap between a tip and the surface of its sphere, in radii of the sphere. At the rim of a flat end it is 0.41.
constexpr double tip_reach_radii = 1;
// First limit of the edges' length, in mean radii. It is halved until the inscribed spheres connect all tips.
constexpr double first_edge_limit = 0.3;
constexpr double finest_edge_limit = 0.075; // smallest limit of the edges' length that is tried, in mean radii
// If neighbouring spheres lead from a tip's sphere this far from the tip (in radii of that sphere), the vessel goes on
// there.
constexpr double continuation_radii = 2;
// A cut that loses more vessel than this (mm) gives a warning. An ostial lesion lies within 3 mm of the ostium.
constexpr double most_unwarned_loss = 2;
constexpr double cut_naming_radii = 3; // largest distance from a point of --cut to the axis, in radii of the vessel
// Tips whose cuts are nearer to each other than this (in radii of the cuts) are one end. A dome wider than the mean
// vessel may have two tips.
constexpr double same_cut_radii = 0.5;

// An end and the distance from its centre within which a tip is part of the end's rim.
struct EndReach {
  const End* end;
  double reach; // mm, to a little beyond the cap's farthest vertex; an oval cap reaches well beyond its radius
};

std::vector<EndReach> end_reaches(const Mesh& mesh, const std::vector<End>& ends) {
  std::map<int, EndReach> found;
  for (const End& end : ends)
    found[end.region] = {&end, 0};
  const RegionMap region = region_map(mesh);
  for (Face f : mesh.faces())
    if (const auto it = found.find(region[f]); it != found.end())
      for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
        it->second.reach = std::max(it->second.reach, (vec(mesh.point(v)) - it->second.end->centre).norm());
  std::vector<EndReach> reaches;
  for (const auto& [tag, at] : found)
    reaches.push_back({at.end, at.reach + rim_margin_radii * at.end->radius()});
  return reaches;
}

// The end within whose reach p lies, or null.
const End* end_at(const Vec3& p, const std::vector<EndReach>& reaches) {
  for (const auto& [end, far] : reaches)
    if ((p - end->centre).norm() < far)
      return end;
  return nullptr;
}

// Distance between a sphere's surface and p, in radii of the sphere.
double gap_in_radii(const Vec3& p, const InscribedSpheres& spheres, std::size_t i) {
  return std::abs((spheres.centre[i] - p).norm() - spheres.radius[i]) / spheres.radius[i];
}

// Index of the largest sphere whose surface is within `near` of p, in radii of the sphere. A chain of neighbours must
// lead from this sphere on into a vessel. If there is none, the number of spheres is returned, which is no valid index.
std::size_t largest_sphere_at(const Vec3& p, const InscribedSpheres& spheres, double near) {
  std::vector<std::size_t> touching;
  for (std::size_t i = 0; i < spheres.centre.size(); ++i)
    if (gap_in_radii(p, spheres, i) < near)
      touching.push_back(i);
  std::stable_sort(touching.begin(), touching.end(),
                   [&](std::size_t a, std::size_t b) { return spheres.radius[a] > spheres.radius[b]; });
  std::vector<bool> seen(spheres.centre.size(), false);
  for (std::size_t i : touching)
    if (leads_away(spheres, i, p, continuation_radii * spheres.radius[i], seen))
      return i;
  return spheres.centre.size();
}

// The spheres whose surface is less than one of their own radii from p, the nearest first.
std::vector<std::size_t> nearest_spheres(const Vec3& p, const InscribedSpheres& spheres) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < spheres.centre.size(); ++i)
    if (gap_in_radii(p, spheres, i) < tip_reach_radii)
      found.push_back(i);
  std::stable_sort(found.begin(), found.end(), [&](std::size_t a, std::size_t b) {
    return gap_in_radii(p, spheres, a) < gap_in_radii(p, spheres, b);
  });
  return found;
}

// The last inscribed sphere of the vessel that ends at the tip: the largest sphere that touches the tip and from which
// neighbouring spheres lead into the vessel. At a corner of a flat end's rim no sphere touches the tip. On a rough wall
// the touching spheres may have no neighbours. In these cases the largest of the spheres whose surfaces come nearest to
// the tip is returned. If no sphere leads on there is no vessel, as in a round cavity, and the nearest sphere is
// returned.
std::size_t last_sphere(const Mesh& mesh, const InscribedSpheres& spheres, Vertex tip) {
  const Vec3 p = vec(mesh.point(tip));
  if (const std::size_t touching = largest_sphere_at(p, spheres, 1e-6); touching < spheres.centre.size())
    return touching;
  const std::vector<std::size_t> nearest = nearest_spheres(p, spheres);
  if (nearest.empty())
    throw InputError(
        "no axis found at a rounded end", point_text(p), "no inscribed ball",
        "cut the end flat, or leave it open; if it is open with a lip, cut the vessel behind the lip by --cut");
  std::vector<bool> seen(spheres.centre.size(), false);
  for (std::size_t i : nearest)
    if (leads_away(spheres, i, p, continuation_radii * spheres.radius[i], seen)) {
      // A larger sphere must lead farther from the tip. If that search fails, it may have visited sphere i already, and
      // then it finds no sphere. In this case sphere i is used.
      const std::size_t largest = largest_sphere_at(p, spheres, gap_in_radii(p, spheres, i) + equal_gap_radii);
      return largest < spheres.centre.size() ? largest : i;
    }
  return nearest.front();
}

// The inscribed sphere at a tip: the end's sphere if an end lies there, else the last sphere of the vessel.
std::size_t sphere_of(const Mesh& mesh, const InscribedSpheres& spheres, const std::vector<EndReach>& reaches,
                      Vertex tip) {
  const End* end = end_at(vec(mesh.point(tip)), reaches);
  return end ? sphere_at_end(spheres, *end) : last_sphere(mesh, spheres, tip);
}

Plane plane_across(const Mesh& mesh, const SpherePath& path, double where) {
  return {path.centre(where), vessel_direction(mesh, path, where), path.radius[path.index_at(where)]};
}

// Finds the first plane across the vessel whose section is like the section half a radius further in. The search starts
// half a radius behind the last sphere's centre. The plane's cutting square covers the section. If no plane fits, the
// last one tried before the middle of the path is returned, or the middle if none was tried.
Plane cut_plane(const Mesh& mesh, const Slices& slices, const SpherePath& path) {
  Plane plane = plane_across(mesh, path, 0.5 * path.length());
  for (double where = behind_sphere_radii * path.radius.front(); where < 0.5 * path.length();
       where += plane_step_radii * path.radius[path.index_at(where)]) {
    const double inscribed = path.radius[path.index_at(where)];
    if (path.radius[path.index_at(where + inscribed)] > tip_taper_ratio * inscribed)
      continue;
    plane = plane_across(mesh, path, where);
    const SectionSize here = slices.section_size({plane.centre, plane.normal});
    Plane further = plane;
    further.centre += behind_sphere_radii * std::sqrt(here.area / pi) * plane.normal;
    const double area = slices.section_size({further.centre, further.normal}).area;
    if (here.area > 0 && area > here.area / similar_area_ratio && area < here.area * similar_area_ratio) {
      plane.radius = std::max(plane.radius, section_cover * here.reach / square_half_width);
      return plane;
    }
  }
  return plane;
}

// A copy of the surface with no wall edge longer than `longest` (mm). Where vessels meet on a coarse surface, a vertex
// normal fits none of the vessels, and the inscribed spheres of such vertices are not neighbours. More vertices connect
// the spheres. The mesh's vertices keep their numbers.
Mesh with_short_edges(const Mesh& mesh, double longest) {
  Mesh out = mesh;
  const RegionMap region = region_map(out);
  std::vector<Edge> wall;
  for (Edge e : out.edges())
    if (region[out.face(out.halfedge(e, 0))] == 0 && region[out.face(out.halfedge(e, 1))] == 0)
      wall.push_back(e);
  PMP::split_long_edges(wall, longest, out);
  return out;
}

// The tips of the surface: the local maxima of the distance along it, measured once from each of its two extremities
// (tips_of). The most prominent come first. One extremity is not enough: a branch that leans towards it makes hardly a
// maximum of the distance from it. Of two tips closer than `apart` (mm) the less prominent one is dropped. `prominence`
// (mm) is the least prominence of a tip.
std::vector<Tip> tips_from_both(const Mesh& mesh, double prominence, double apart) {
  std::vector<Tip> all = tips_of(mesh, prominence), tips;
  const std::vector<Tip> from_far_end = tips_of(mesh, prominence, true);
  all.insert(all.end(), from_far_end.begin(), from_far_end.end());
  std::stable_sort(all.begin(), all.end(), [](const Tip& a, const Tip& b) { return a.prominence > b.prominence; });
  for (const Tip& tip : all) {
    const Vec3 at = vec(mesh.point(tip.vertex));
    if (std::none_of(tips.begin(), tips.end(),
                     [&](const Tip& kept) { return (vec(mesh.point(kept.vertex)) - at).norm() < apart; }))
      tips.push_back(tip);
  }
  return tips;
}

// Whether the planes of two tips make about the same cut.
bool make_same_cut(const Plane& a, const Plane& b) {
  return (a.centre - b.centre).norm() < same_cut_radii * std::max(a.radius, b.radius) && a.normal.dot(b.normal) > 0;
}

// The inscribed spheres of a surface, and the index of each tip's sphere.
struct TipSpheres {
  InscribedSpheres spheres;
  std::vector<std::size_t> tip_sphere;
};

// Whether chains of neighbouring spheres connect the first tip's sphere with the sphere of every other tip.
bool are_connected(const TipSpheres& tips) {
  const ShortestPaths cheapest = cheapest_paths(tips.spheres, tips.tip_sphere.front());
  return std::all_of(tips.tip_sphere.begin(), tips.tip_sphere.end(),
                     [&](std::size_t sphere) { return cheapest.cost[sphere] < unreached; });
}

// The inscribed spheres of the surface and each tip's sphere. The wall's edges are split more finely until the spheres
// connect all tips, or down to finest_edge_limit.
TipSpheres spheres_of_tips(const Mesh& mesh, const std::vector<End>& ends, const std::vector<EndReach>& reaches,
                           const std::vector<Tip>& tips) {
  for (double longest = first_edge_limit;; longest /= 2) {
    TipSpheres found{inscribed_spheres(with_short_edges(mesh, longest * mean_radius(mesh)), ends), {}};
    for (const Tip& tip : tips)
      found.tip_sphere.push_back(sphere_of(mesh, found.spheres, reaches, tip.vertex));
    if (longest < 2 * finest_edge_limit || are_connected(found))
      return found;
  }
}

} // namespace

std::vector<RoundedEnd> rounded_ends(const Mesh& mesh, const std::vector<End>& ends, double prominence,
                                     bool from_both) {
  const double mean = mean_radius(mesh);
  const std::vector<Tip> tips =
      from_both ? tips_from_both(mesh, prominence * mean, mean) : tips_of(mesh, prominence * mean);
  const std::vector<EndReach> reaches = end_reaches(mesh, ends);
  const auto is_rounded = [&](const Tip& tip) { return !end_at(vec(mesh.point(tip.vertex)), reaches); };
  if (tips.size() < 2 || std::none_of(tips.begin(), tips.end(), is_rounded))
    return {};
  const TipSpheres found = spheres_of_tips(mesh, ends, reaches, tips);
  const Slices slices(mesh);
  std::vector<RoundedEnd> rounded;
  for (std::size_t t = 0; t < tips.size(); ++t) {
    const Tip& tip = tips[t];
    if (!is_rounded(tip))
      continue;
    const SpherePath path(found.spheres, cheapest_paths(found.spheres, found.tip_sphere[t == 0 ? 1 : 0]),
                          found.tip_sphere[t]);
    RoundedEnd end{
        tip.vertex,
        vec(mesh.point(tip.vertex)),
        cut_plane(mesh, slices, path),
        path.radius.front(),
        *std::max_element(path.radius.begin(),
                          path.radius.begin() + static_cast<std::ptrdiff_t>(path.index_at(tip.prominence / 2)) + 1),
        tip.prominence,
        path.points.size() > 1,
        ""};
    char why[160] = "";
    if (path.length() < path.radius.front()) // a surface like a sphere has tips but no vessel between them
      std::snprintf(why, sizeof why, "its axis is %.2f mm long, less than its radius", path.length());
    else if (tip.prominence < std::max(least_prominence * mean, least_sphere_prominence * path.radius.front()))
      std::snprintf(why, sizeof why, "it stands out by %.2f mm only: a stub", tip.prominence);
    end.too_short_reason = why;
    if (std::none_of(rounded.begin(), rounded.end(),
                     [&](const RoundedEnd& before) { return make_same_cut(before.plane, end.plane); }))
      rounded.push_back(end);
  }
  return rounded;
}

std::vector<Tip> tips_beside_ends(const Mesh& mesh, const std::vector<End>& ends, double prominence) {
  std::vector<Tip> tips = tips_from_both(mesh, prominence, mean_radius(mesh));
  const std::vector<EndReach> reaches = end_reaches(mesh, ends);
  std::erase_if(tips, [&](const Tip& tip) { return end_at(vec(mesh.point(tip.vertex)), reaches) != nullptr; });
  return tips;
}

void cut_rounded(Mesh& mesh, const RoundedEnd& end, std::vector<Repair>& repairs) {
  const double lost_length = end.plane.normal.dot(end.plane.centre - end.position);
  report_cut(
      repairs, "rounded end cut flat", end.plane,
      cut_at_plane(mesh, end.plane, end.tip, "cut the end flat or leave it open, or cut the vessel there by --cut"));
  char suffix[48];
  std::snprintf(suffix, sizeof suffix, ", %.1f mm of the vessel", lost_length);
  repairs.back().detail += suffix;
  repairs.back().warning = lost_length > most_unwarned_loss;
}

void cut_across(Mesh& mesh, const Mesh& tagged, const std::vector<End>& ends, const std::vector<Vec3>& points,
                std::vector<Repair>& repairs) {
  const std::vector<Tip> tips = tips_of(tagged, least_prominence * mean_radius(tagged));
  const InscribedSpheres spheres = inscribed_spheres(tagged, ends);
  const std::vector<EndReach> reaches = end_reaches(tagged, ends);
  std::vector<SpherePath> paths;
  if (tips.size() >= 2) {
    const ShortestPaths from_tip = cheapest_paths(spheres, sphere_of(tagged, spheres, reaches, tips[0].vertex));
    for (std::size_t t = 1; t < tips.size(); ++t)
      paths.emplace_back(spheres, from_tip, sphere_of(tagged, spheres, reaches, tips[t].vertex));
  }
  for (const Vec3& p : points) {
    const SpherePath* nearest = nullptr;
    std::size_t at = 0;
    double least = 1e300;
    for (const SpherePath& path : paths)
      for (std::size_t i = 0; i < path.points.size(); ++i)
        if ((path.points[i] - p).norm() < least) {
          least = (path.points[i] - p).norm();
          nearest = &path;
          at = i;
        }
    if (!nearest || least > cut_naming_radii * nearest->radius[at])
      throw InputError("no vessel near the point to cut at", "--cut", point_text(p),
                       "give a point on the vessel's axis");
    const Plane plane = plane_across(tagged, *nearest, nearest->s[at]);
    report_cut(repairs, "vessel cut across", plane,
               cut_at_plane(mesh, plane, Mesh::null_vertex(), "give a point where the vessel is round and alone"));
  }
  mesh.collect_garbage();
}

} // namespace anatomy
