#include "app/prepare.hpp"
#include "app/checks.hpp"
#include "common/error.hpp"
#include "core/measures.hpp"
#include "ends/cap_open_ends.hpp"
#include "ends/ends.hpp"
#include "ends/given_caps.hpp"
#include "ends/ragged_ends.hpp"
#include "files/surface_file.hpp"
#include "measure/grid_of_surface.hpp"
#include "remesh/refine.hpp"
#include "repair/handles.hpp"
#include "repair/repair.hpp"
#include <iostream>

namespace anatomy {
namespace {

using common::InputError;

// Least radius of a flat end of a mask's surface, in voxel edges. The wall of a thin lumen has facets of about one
// voxel.
constexpr double smallest_cap = 1.5;

// Throws InputError if an option is out of range. The shortest edge is a tenth of CT's resolution, and gives a tree a
// million triangles. The longest edge is more than a coronary's radius. An extension of less than half a radius is
// shorter than the edges of a thin end; twenty radii are as long as most vessels.
void check_options(const Options& options) {
  if (!(options.edge >= 0.05 && options.edge <= 2))
    throw InputError("edge length out of range", "--edge", std::to_string(options.edge) + " mm", "choose 0.05 to 2 mm");
  if (!(options.spacing >= 0.05 && options.spacing <= 2))
    throw InputError("section spacing out of range", "--spacing", std::to_string(options.spacing) + " mm",
                     "choose 0.05 to 2 mm");
  for (double radii : {options.extend_inlet, options.extend_outlets})
    if (!(radii == 0 || (radii >= 0.5 && radii <= 20)))
      throw InputError("flow extension out of range", "--extend-inlet, --extend-outlets",
                       std::to_string(radii) + " radii", "choose 0.5 to 20 radii, or 0 for none");
  if (!options.caps.empty() && (options.inlet || !options.outlets.empty()))
    throw InputError("ends given twice", "--cap", "with --inlet or --outlet", "give caps or points, not both");
  if (options.caps.size() == 1)
    throw InputError("one cap for a vessel with two ends or more", options.caps.front(), "1 cap",
                     "give the cap of every end, the inlet's first");
}

std::set<int> tags_of(const std::vector<OpenEnd>& open) {
  std::set<int> tags;
  for (const OpenEnd& end : open)
    tags.insert(end.tag);
  return tags;
}

// The ends that the user names: by points, or by `caps`, the centres (mm) of the openings of the cap files.
NamedEnds named_ends(const Options& options, const std::vector<Vec3>& caps) {
  NamedEnds named;
  named.inlet = options.inlet;
  named.outlets = options.outlets;
  named.close_others = options.close_others;
  named.cuts = options.cuts;
  if (!caps.empty())
    named.inlet = caps.front();
  for (std::size_t k = 1; k < caps.size(); ++k)
    named.outlets.push_back(caps[k]);
  return named;
}

std::vector<Vec3> points_of(const NamedEnds& named) {
  std::vector<Vec3> points = named.outlets;
  if (named.inlet)
    points.push_back(*named.inlet);
  return points;
}

// Tags of the caps that close openings: those tags that are not in the surface's own region_id.
std::set<int> tags_of_openings(const Mesh& mesh, const Soup& soup) {
  std::set<int> tags;
  for (const auto& [tag, faces] : tagged_faces(mesh))
    if (std::find(soup.region.begin(), soup.region.end(), tag) == soup.region.end())
      tags.insert(tag);
  return tags;
}

// The voxels of the mask, or else those of the grid on which the surface was contoured.
Voxels voxels_of(vtkPolyData* input, const Mesh& mesh) {
  const double edge = voxel_edge(input);
  return edge > 0 ? Voxels{edge, true} : Voxels{grid_of_surface(mesh), false};
}

// If the outlets come from cap files (`caps`), drops those whose end is not in the tree. The inlet of the tree is at
// its ostium.
void keep_ends_of_tree(const Mesh& tree, bool caps, NamedEnds& named) {
  if (caps) {
    Mesh copy = tree;
    const std::vector<End> ends = measure_ends(copy);
    std::erase_if(named.outlets, [&](const Vec3& p) {
      return std::none_of(ends.begin(), ends.end(),
                          [&](const End& end) { return (end.centre - p).norm() < end.radius(); });
    });
  }
}

} // namespace

void print_warnings(const std::vector<Repair>& repairs, std::size_t from) {
  for (std::size_t i = from; i < repairs.size(); ++i)
    if (repairs[i].warning)
      std::cerr << "lumen: warning: " << repairs[i].what << ": " << repairs[i].detail << '\n';
}

TreeChoice tree_choice_of(const Options& options) {
  return {options.tree, options.ostium, options.outlets, options.whole};
}

ClosedSurface closed_surface(const Options& options, StepTimer& timer) {
  check_options(options);
  ClosedSurface out;
  timer.start("read");
  const std::vector<GivenCap> caps = read_caps(options.caps, options.unit);
  out.input = read_surface(options.input, options.unit, options.labels, out.repairs, options.inlet);
  const Soup soup = soup_of(out.input);
  timer.start("repair");
  out.mesh =
      repaired(soup, out.repairs,
               caps.empty() ? ends_at_points(points_of(named_ends(options, {}))) : ends_at_caps(caps), options.inlet);
  region_map(out.mesh);
  if (!soup.region.empty())
    tag_from_soup(out.mesh, soup);
  timer.start("ends");
  out.named = named_ends(options, open_given_caps(out.mesh, caps));
  fill_tears(out.mesh, points_of(out.named), out.repairs);
  const std::vector<OpenEnd> open = cap_open_ends(out.mesh, out.repairs);
  orient_outward(out.mesh, out.repairs);
  remove_small_handles(out.mesh, out.repairs);
  // Later steps do not remove handles, and take long if there are many. A few are allowed here, since they may belong
  // to an aorta that is cut off.
  check_no_handle(out.mesh, most_touching_rings);
  timer.start("self-intersections");
  remove_self_intersections(out.mesh, out.repairs);
  check_no_handle(out.mesh, most_touching_rings);
  drop_scraps_of_caps(out.mesh, tags_of(open), out.repairs);
  cut_ragged(out.mesh, open, out.repairs);
  timer.start("aorta");
  out.named.openings = tags_of_openings(out.mesh, soup);
  out.named.tagged = !caps.empty() || !soup.region.empty();
  if (options.like.empty()) // the surface of an earlier state has no aorta: it is cut off already
    out.aorta = find_aorta_to_cut(out.mesh, tree_choice_of(options), options.unit, out.repairs);
  if (!out.aorta)
    check_no_handle(out.mesh);
  return out;
}

PreparedLumen find_lumen_ends(ClosedSurface closed, const CoronaryTree* tree, const Options& options,
                              StepTimer& timer) {
  PreparedLumen out;
  out.input = closed.input;
  out.mesh = std::move(closed.mesh);
  // The voxels are found before cuts add vertices in planes, which would look like a voxel grid's.
  out.voxels = voxels_of(out.input, out.mesh);
  out.named = std::move(closed.named);
  out.repairs = std::move(closed.repairs);
  if (tree) {
    const Plane plane = tree_cut_plane(out.mesh, *tree, tree_choice_of(options));
    cut_tree_off_aorta(out.mesh, *tree, plane, out.repairs);
    keep_ends_of_tree(out.mesh, !options.caps.empty(), out.named);
    std::set<int> known;
    for (const auto& [tag, faces] : tagged_faces(out.mesh))
      known.insert(tag);
    cap_open_ends(out.mesh, out.repairs);
    check_no_handle(out.mesh);
    for (const auto& [tag, faces] : tagged_faces(out.mesh))
      if (!known.contains(tag))
        out.named.openings.insert(tag);
    if (!options.inlet)
      out.named.inlet = plane.centre;
  }
  timer.start("caps");
  out.candidates = find_ends(out.mesh, out.named, smallest_cap * voxel_edge(out.input), out.repairs);
  out.ends = measure_ends(out.mesh);
  if (tree)
    check_no_stub(out.mesh, out.ends, !out.named.outlets.empty() || out.named.tagged, out.repairs);
  else if (out.named.outlets.empty() && !out.named.tagged && out.ends.size() >= 2) {
    warn_of_stubs(out.mesh, out.ends, out.candidates, out.repairs);
    if (!out.named.inlet && options.like.empty())
      check_no_wide_stub(out.mesh, out.ends);
  }
  check_no_handle(out.mesh);
  report_cap_move(out.repairs, flatten_caps(out.mesh), out.ends.size());
  check_mean_radius(mean_radius(out.mesh), options.unit, options.input);
  out.unrefined = out.mesh;
  if (is_coarse(out.mesh)) {
    out.mesh = curved_refined(out.mesh);
    out.splits = 2;
  }
  return out;
}

PreparedLumen prepare(const Options& options, StepTimer& timer) {
  ClosedSurface closed = closed_surface(options, timer);
  std::optional<CoronaryTree> tree;
  if (closed.aorta)
    tree = choose_tree(*closed.aorta, tree_choice_of(options));
  PreparedLumen out = find_lumen_ends(std::move(closed), tree ? &*tree : nullptr, options, timer);
  print_warnings(out.repairs, 0);
  return out;
}

} // namespace anatomy
