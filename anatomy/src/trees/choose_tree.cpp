#include "trees/choose_tree.hpp"
#include "common/error.hpp"
#include "core/measures.hpp"
#include <CGAL/Polygon_mesh_processing/bbox.h>
#include <algorithm>

namespace anatomy {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using common::InputError;

// A model in cm whose unit was declared as mm is ten times too small.
constexpr double cm_scale = 0.1;       // `scale` of find_aorta() for such a model
constexpr double aorta_in_cm = 25;     // largest diagonal of such a model, in declared mm
constexpr double coronary_in_cm = 0.5; // its largest ostium, in declared mm; true vessels of 0.5 mm are never treated
constexpr double least_tree_in_cm = 2; // least length of its longest coronary tree, in declared mm
// The user's points must be this near to a tree, by distance_in_radii().
constexpr double ostium_reach = 3;
constexpr double outlet_reach = 3;

// The trees in words, for messages.
std::string list_trees(const Aorta& aorta) {
  std::string text;
  for (const CoronaryTree& tree : aorta.trees)
    text += (text.empty() ? "" : "; ") + tree_line(tree);
  return text;
}

std::string point_option(const Vec3& p) {
  char text[96];
  std::snprintf(text, sizeof text, "--ostium %.2f,%.2f,%.2f", p.x(), p.y(), p.z());
  return text;
}

std::string remedy_of(const Aorta& aorta) {
  std::string text;
  for (const CoronaryTree& tree : aorta.trees)
    text += (text.empty() ? "" : " or ") +
            (aorta.unnamed_reason.empty() ? "--tree " + tree.name : point_option(tree.ostium.centre));
  return "choose one by " + text + " (case file: " + (aorta.unnamed_reason.empty() ? "tree" : "ostium_point_mm") + ")";
}

// Throws InputError if the mesh looks like an aorta with coronary arteries in cm although the user declared mm.
void check_not_in_cm(const Mesh& mesh, LengthUnit unit) {
  const CGAL::Bbox_3 box = PMP::bbox(mesh);
  const Vec3 size(box.xmax() - box.xmin(), box.ymax() - box.ymin(), box.zmax() - box.zmin());
  if (unit != LengthUnit::mm || size.norm() > aorta_in_cm)
    return;
  const std::optional<Aorta> aorta = find_aorta(mesh, cm_scale);
  if (!aorta || !aorta->is_evident(cm_scale))
    return;
  double widest = 0, longest = 0;
  for (const CoronaryTree& tree : aorta->trees) {
    widest = std::max(widest, tree.diameter);
    longest = std::max(longest, tree.length);
  }
  if (widest > coronary_in_cm || longest < least_tree_in_cm)
    return;
  char value[160];
  std::snprintf(value, sizeof value, "a trunk %.2f mm wide with branches of %.2f mm at the most with units mm",
                aorta->diameter, widest);
  throw InputError("implausible scale for an aorta with its coronary arteries", "at " + point_text(aorta->centre),
                   value,
                   "the file is likely in cm: declare units cm; if the vessel is as small as that, give --tree whole");
}

} // namespace

std::string tree_line(const CoronaryTree& tree) {
  char text[200];
  if (tree.diameter > 0)
    std::snprintf(text, sizeof text, "%s: ostium at %s, diameter %.2f mm, %.0f mm long", tree.name.c_str(),
                  point_text(tree.ostium.centre).c_str(), tree.diameter, tree.length);
  else
    std::snprintf(text, sizeof text, "%s: leaves the aorta near %s, no plane across its ostium found, %.0f mm long",
                  tree.name.c_str(), point_text(tree.ostium.centre).c_str(), tree.length);
  return text;
}

std::optional<Aorta> find_aorta_to_cut(const Mesh& mesh, const TreeChoice& choice, LengthUnit unit,
                                       std::vector<Repair>& repairs) {
  if (choice.whole)
    return std::nullopt;
  std::optional<Aorta> aorta = find_aorta(mesh);
  if (aorta && (aorta->is_evident() || (choice.is_given() && !aorta->trees.empty()))) {
    if (!aorta->lost_tips.empty() && !choice.is_given())
      throw InputError("a vessel on the aorta that could not be followed",
                       "its tip is at " + point_text(aorta->lost_tips[0]),
                       std::to_string(aorta->trees.size()) + " coronary trees found: " + list_trees(*aorta),
                       "export a finer surface, or choose one of these trees by --tree or --ostium");
    for (const End& end : aorta->stray_ends)
      repairs.push_back({"end beside the aorta left away", 1,
                         "at " + point_text(end.centre) + ", diameter " + std::to_string(2 * end.radius()) +
                             " mm: no coronary tree longer than 4.5 mm leads there",
                         true});
    return aorta;
  }
  check_not_in_cm(mesh, unit);
  if (choice.is_given())
    throw InputError(aorta ? "no coronary tree found on the aorta" : "no aorta found", "--tree, --ostium",
                     aorta ? "a trunk " + std::to_string(aorta->diameter) + " mm wide at " + point_text(aorta->centre)
                           : "no part of the lumen is wider than 9 mm",
                     aorta ? "check that the model has its coronary arteries, or cut the tree off by --cut"
                           : "leave --tree and --ostium away, or cut the vessel by --cut");
  if (aorta && aorta->ends >= 2 && !aorta->trees.empty()) {
    char detail[240];
    std::snprintf(detail, sizeof detail,
                  "%.1f mm at %s; if it is an aorta, give --tree or --ostium to cut a coronary tree off",
                  aorta->diameter, point_text(aorta->centre).c_str());
    repairs.push_back({"wide vessel taken for a coronary artery", 1, detail, true});
  }
  return std::nullopt;
}

const CoronaryTree& choose_tree(const Aorta& aorta, const TreeChoice& choice) {
  const auto& trees = aorta.trees;
  if (choice.ostium) {
    const auto nearest =
        std::min_element(trees.begin(), trees.end(), [&](const CoronaryTree& a, const CoronaryTree& b) {
          return distance_in_radii(a, *choice.ostium) < distance_in_radii(b, *choice.ostium);
        });
    if (distance_in_radii(*nearest, *choice.ostium) > ostium_reach)
      throw InputError("no coronary tree near the given ostium", "--ostium", point_text(*choice.ostium),
                       "trees found: " + list_trees(aorta) + "; " + remedy_of(aorta));
    return *nearest;
  }
  if (trees.size() == 1) // regardless of its name
    return trees.front();
  if (!choice.name.empty()) {
    const auto named =
        std::find_if(trees.begin(), trees.end(), [&](const CoronaryTree& tree) { return tree.name == choice.name; });
    if (named != trees.end())
      return *named;
    throw InputError("no coronary tree of that name", "--tree " + choice.name,
                     list_trees(aorta) + (aorta.unnamed_reason.empty() ? "" : " (" + aorta.unnamed_reason + ")"),
                     remedy_of(aorta));
  }
  if (!choice.outlets.empty())
    for (const CoronaryTree& tree : trees)
      if (std::all_of(choice.outlets.begin(), choice.outlets.end(),
                      [&](const Vec3& p) { return distance_in_radii(tree, p) < outlet_reach; }))
        return tree;
  throw InputError(
      "an aorta with several coronary trees, one of which is meant", "aorta at " + point_text(aorta.centre),
      list_trees(aorta) + (aorta.unnamed_reason.empty() ? "" : " (" + aorta.unnamed_reason + ")"), remedy_of(aorta));
}

Plane tree_cut_plane(const Mesh& mesh, const CoronaryTree& tree, const TreeChoice& choice) {
  if (choice.ostium)
    if (const auto plane = plane_across_tree(mesh, tree, *choice.ostium))
      return *plane;
  if (tree.diameter == 0)
    throw InputError("no plane across the ostium of a coronary tree found", point_text(tree.ostium.centre),
                     tree_line(tree), "give --ostium x,y,z, a point on the tree's axis where it is to be cut");
  return tree.ostium;
}

void cut_tree_off_aorta(Mesh& mesh, const CoronaryTree& tree, const Plane& plane, std::vector<Repair>& repairs) {
  Vertex tip = Mesh::null_vertex();
  double least = 1e300;
  for (Vertex v : mesh.vertices())
    if (const double d = (vec(mesh.point(v)) - tree.offshoot.path.points.front()).norm(); d < least) {
      least = d;
      tip = v;
    }
  cut_and_keep(mesh, plane, tip, "give --ostium x,y,z, a point on the tree's axis where it is alone");
  remove_isolated_vertices(mesh);
  mesh.collect_garbage();
  char detail[200];
  std::snprintf(detail, sizeof detail, "%s, at %s; the aorta and what else hangs on it is left away", tree.name.c_str(),
                point_text(plane.centre).c_str());
  repairs.push_back({"coronary tree cut off at its ostium", 1, detail});
}

} // namespace anatomy
