#include "trees/aorta.hpp"
#include "core/slices.hpp"
#include "core/wall_tree.hpp"
#include "ends/ends.hpp"
#include "ends/find_ends.hpp"
#include "repair/tips.hpp"
#include <algorithm>

namespace anatomy {
namespace {

constexpr double trunk_radius = 4.5;      // mm; spheres larger than this fill the trunk, so it is wider than 9 mm
constexpr double least_tree_length = 4.5; // mm outside the trunk: corners of the trunk's ends and sinuses reach less
constexpr double widest_coronary = 12;    // mm, diameter of the widest ectatic arteries, single sacs excepted
constexpr double aorta_with_one_end = 18; // mm, least width of an aorta closed at the valve; coronary sacs have less
constexpr double widest_ostium = 9;       // mm, largest diameter of a coronary ostium
constexpr double narrowest_ostium = 0.8;  // mm, smallest diameter of a coronary ostium
// Numbers of the wall's vertices, roughly, from which the spheres are computed: for the result, and for the quick test
// may_hold_sphere().
constexpr std::size_t final_vertices = 60000, trial_vertices = 3000;
constexpr double plane_step_radii = 0.25;   // distance between the planes that are tried across a tree, in sphere radii
constexpr double funnel_ratio = 1.15;       // in an ostium's funnel, spheres one radius apart differ by a larger ratio
constexpr double similar_area_ratio = 1.25; // up to this ratio the areas of sections half a radius apart are alike
constexpr double largest_section_ratio = 2.5; // in areas of the sphere's circle; a larger one reaches into the aorta
constexpr double longest_funnel = 20; // mm; the ostium's plane is sought within this length of the tree from the aorta
constexpr double arch_direction_length = 15; // mm of the trunk's path that give the direction to the arch
constexpr double tree_end_radii = 2; // an end within this many sphere radii of a tree's sphere belongs to the tree
constexpr double tree_tip_radii = 4; // the same for a tip of the surface; a corner of a cap is a tip at about 1.5
// Least prominence (mm along the surface) of a vessel that is reported as lost.
constexpr double least_lost_prominence = 10;
// Least ratio of the distances from the ostia to the aorta's two ends. Below it, the side of the arch is unsure.
constexpr double least_root_ratio = 1.3;
// Degrees between the ostia round the aorta. Outside this range the names left and right are unsure.
constexpr double least_ostia_angle = 60, most_ostia_angle = 165;

// The n of "every n-th vertex", so that about `vertices` remain.
std::size_t vertex_stride(const Mesh& mesh, std::size_t vertices) {
  return mesh.number_of_vertices() / vertices + 1;
}

// Whether a sphere of more than `radius` (mm) may fit into the lumen. The test is quick as it uses only a part of the
// vertices. This makes no sphere smaller, so a "no" is certain.
bool may_hold_sphere(const Mesh& mesh, double radius) {
  const InscribedSpheres spheres = inscribed_spheres(mesh, {}, vertex_stride(mesh, trial_vertices));
  return std::any_of(spheres.radius.begin(), spheres.radius.end(), [&](double r) { return r > radius; });
}

// Finds the plane across a tree where the funnel of its ostium has ended, and sets the tree's ostium and diameter. If
// there is no such plane, the diameter stays 0. `scale` as in find_aorta().
void find_ostium(const Mesh& mesh, const Slices& slices, double scale, CoronaryTree& tree) {
  const SpherePath& path = tree.offshoot.path;
  const double from = tree.offshoot.outside_length, until = std::max(0.0, from - longest_funnel * scale);
  for (double where = from; where > until; where -= plane_step_radii * path.radius[path.index_at(where)]) {
    const double inscribed = path.radius[path.index_at(where)];
    tree.ostium = {path.centre(where), -vessel_direction(mesh, path, where), inscribed};
    if (where > inscribed && inscribed > funnel_ratio * path.radius[path.index_at(where - inscribed)])
      continue;
    const SectionSize here = slices.section_size({tree.ostium.centre, tree.ostium.normal});
    if (here.area <= 0 || here.area > largest_section_ratio * pi * inscribed * inscribed)
      continue;
    const Vec3 further = tree.ostium.centre + 0.5 * std::sqrt(here.area / pi) * tree.ostium.normal;
    const double area = slices.section_size({further, tree.ostium.normal}).area;
    if (area > here.area / similar_area_ratio && area < here.area * similar_area_ratio) {
      tree.ostium.radius = std::max(inscribed, section_cover * here.reach / square_half_width);
      tree.diameter = 2 * std::sqrt(here.area / pi);
      return;
    }
  }
}

// All ends of the mesh: its tagged openings, and flat parts as wide as a trunk, which are tagged here. `radius` is the
// least radius of a trunk, mm.
std::vector<End> tagged_trunk_ends(Mesh& mesh, double radius) {
  RegionMap region = region_map(mesh);
  int next = 0;
  for (const auto& [tag, faces] : tagged_faces(mesh))
    next = std::max(next, tag);
  for (const auto& faces : flat_ends(mesh, radius)) {
    ++next;
    for (Face f : faces)
      region[f] = next;
  }
  return measure_ends(mesh);
}

// Unit direction along the aorta at the coronary ostia, towards the arch. The arch is on the side of the aorta's
// farther end. Nothing if both ends are about equally far from the ostia.
// @param ends the aorta's own ends
// @param ostia midpoint of the two ostia, mm
std::optional<Vec3> direction_to_arch(const Trunk& trunk, const std::vector<End>& ends, const Vec3& ostia,
                                      double scale) {
  std::optional<Vec3> up;
  double longest = 0, shortest = 1e300;
  for (const End& end : ends) {
    const double d = (end.centre - ostia).norm();
    shortest = std::min(shortest, d);
    if (d < longest)
      continue;
    longest = d;
    Vec3 from = ostia, to = end.centre;
    double nearest = 1e300;
    const std::vector<Vec3> path = trunk.path_to(end.centre);
    for (const Vec3& p : path)
      if ((p - ostia).norm() < nearest) {
        nearest = (p - ostia).norm();
        from = p;
      }
    for (auto p = path.rbegin(); p != path.rend() && (*p - from).norm() > arch_direction_length * scale; ++p)
      to = *p;
    up = (to - from).normalized();
  }
  if (ends.size() > 1 && longest < least_root_ratio * shortest)
    return std::nullopt;
  return up;
}

// Names two trees by their order round the aorta. Returns why the names are not certain, or an empty text.
std::string name_by_order(const Trunk& trunk, const std::vector<End>& ends, double scale,
                          std::vector<CoronaryTree>& trees) {
  if (trees.size() != 2)
    return "left and right are told of two trees only";
  const Vec3 ostia = 0.5 * (trees[0].ostium.centre + trees[1].ostium.centre);
  const std::optional<Vec3> up = direction_to_arch(trunk, ends, ostia, scale);
  if (!up)
    return "the ostia are about as far from the one end of the aorta as from the other";
  const auto perpendicular = [&](const Vec3& p) {
    const Vec3 d = p - trunk.centre_near(ostia);
    return Vec3((d - d.dot(*up) * *up).normalized());
  };
  const Vec3 a = perpendicular(trees[0].ostium.centre), b = perpendicular(trees[1].ostium.centre);
  const double angle = std::acos(std::clamp(a.dot(b), -1.0, 1.0)) * 180 / pi;
  if (angle < least_ostia_angle || angle > most_ostia_angle) {
    char text[120];
    std::snprintf(text, sizeof text, "the ostia are %.0f degrees apart round the aorta", angle);
    return text;
  }
  const bool first_is_right = up->dot(a.cross(b)) > 0;
  trees[0].name = first_is_right ? "right" : "left";
  trees[1].name = first_is_right ? "left" : "right";
  if (first_is_right)
    std::swap(trees[0], trees[1]);
  return "";
}

} // namespace

bool Aorta::is_evident(double scale) const {
  return !trees.empty() &&
         ((ends >= 2 && diameter > widest_coronary * scale) || (ends == 1 && diameter > aorta_with_one_end * scale));
}

std::optional<Aorta> find_aorta(const Mesh& given, double scale) {
  const double radius = trunk_radius * scale;
  if (!may_hold_sphere(given, radius))
    return std::nullopt;
  Mesh mesh = given;
  const std::vector<End> all_ends = tagged_trunk_ends(mesh, radius);
  const std::optional<Trunk> trunk =
      Trunk::of(inscribed_spheres(mesh, all_ends, vertex_stride(mesh, final_vertices)), WallTree(mesh), radius);
  if (!trunk)
    return std::nullopt;
  std::vector<End> ends;
  for (const End& end : all_ends)
    if (end.radius() > radius && trunk->contains(end.centre - 0.5 * radius * end.normal))
      ends.push_back(end);
  Aorta aorta;
  aorta.diameter = 2 * trunk->radius();
  aorta.centre = trunk->centre();
  aorta.ends = ends.size();
  const Slices slices(given);
  for (Offshoot& offshoot : trunk->offshoots(least_tree_length * scale)) {
    CoronaryTree tree;
    tree.length = offshoot.outside_length;
    tree.offshoot = std::move(offshoot);
    find_ostium(given, slices, scale, tree);
    if (tree.diameter == 0 || (tree.diameter > narrowest_ostium * scale && tree.diameter < widest_ostium * scale))
      aorta.trees.push_back(std::move(tree));
  }
  for (const End& end : all_ends)
    if (end.radius() <= radius && std::none_of(aorta.trees.begin(), aorta.trees.end(), [&](const CoronaryTree& tree) {
          return distance_in_radii(tree, end.centre) < tree_end_radii;
        }))
      aorta.stray_ends.push_back(end);
  for (const Tip& tip : tips_of(given, least_lost_prominence * scale)) {
    const Vec3 p = vec(given.point(tip.vertex));
    if (trunk->distance_outside(p) > radius &&
        std::none_of(aorta.trees.begin(), aorta.trees.end(),
                     [&](const auto& tree) { return distance_in_radii(tree, p) < tree_tip_radii; }))
      aorta.lost_tips.push_back(p);
  }
  for (std::size_t t = 0; t < aorta.trees.size(); ++t)
    aorta.trees[t].name = "tree" + std::to_string(t + 1);
  aorta.unnamed_reason = name_by_order(*trunk, ends, scale, aorta.trees);
  return aorta;
}

double distance_in_radii(const CoronaryTree& tree, const Vec3& p) {
  double least = 1e300;
  for (const auto& [centre, radius] : tree.offshoot.spheres)
    least = std::min(least, (centre - p).norm() / radius);
  return least;
}

std::optional<Plane> plane_across_tree(const Mesh& mesh, const CoronaryTree& tree, const Vec3& p) {
  const SpherePath& path = tree.offshoot.path;
  const auto nearest = std::min_element(path.points.begin(), path.points.end(),
                                        [&](const Vec3& a, const Vec3& b) { return (a - p).norm() < (b - p).norm(); });
  const double where = path.s[static_cast<std::size_t>(nearest - path.points.begin())];
  if (where >= tree.offshoot.outside_length)
    return std::nullopt;
  const Slices slices(mesh);
  Plane plane{path.centre(where), -vessel_direction(mesh, path, where), path.radius[path.index_at(where)]};
  const SectionSize here = slices.section_size({plane.centre, plane.normal});
  if (here.area <= 0)
    return std::nullopt;
  plane.radius = std::max(plane.radius, section_cover * here.reach / square_half_width);
  return plane;
}

} // namespace anatomy
