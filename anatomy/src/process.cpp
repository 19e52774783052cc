#include "process.hpp"
#include "cap_files.hpp"
#include "common/error.hpp"
#include "cut_ends.hpp"
#include "ends.hpp"
#include "extend.hpp"
#include "local_edge.hpp"
#include "refine.hpp"
#include "repair.hpp"
#include "surface_file.hpp"
#include "tips.hpp"
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/repair.h>
#include <filesystem>
#include <fstream>
#include <vtkCellData.h>

namespace anatomy {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using common::InputError;

nlohmann::json read_like(const std::string& path) {
  std::ifstream file(path);
  if (!file)
    throw InputError("no such file", path, "missing", "give the anatomy.json of the earlier state");
  nlohmann::json like = nlohmann::json::parse(file, nullptr, false);
  if (like.is_discarded() || like.value("schema", "") != "vci-anatomy-1" || !like.contains("ends"))
    throw InputError("not an anatomy summary", path, "no schema vci-anatomy-1", "give an anatomy.json");
  return like;
}

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
}

// Tags as numbered by the tree, instead of by area.
void retag(Mesh& mesh, const std::vector<End>& ends, const std::vector<End>& before) {
  RegionMap region = region_map(mesh);
  for (Face f : mesh.faces())
    for (std::size_t e = 0; e < ends.size(); ++e)
      if (region[f] == before[e].region) {
        region[f] = ends[e].region;
        break;
      }
}

// Cuts what the user asks for and the ends that are rounded, and caps the openings.
void cut_flat(Prepared& out, const Options& options) {
  std::vector<Vec3> wanted = options.outlets;
  if (options.inlet)
    wanted.push_back(*options.inlet);
  cut_across(out.mesh, out.ends, options.cuts, out.repairs);
  cap_open_ends(out.mesh, out.repairs);
  out.ends = measured_ends(out.mesh);
  if (!cut_tips(out.mesh, out.ends, wanted, out.repairs))
    return;
  cap_open_ends(out.mesh, out.repairs);
  out.ends = measured_ends(out.mesh);
}

// Vessels that fuse beside each other, as hairpins do in a segmentation, leave a closed surface with a handle.
void check_no_handle(Mesh& mesh) {
  PMP::remove_isolated_vertices(mesh);
  mesh.collect_garbage();
  if (const auto where = place_on_handle(mesh))
    throw InputError("the lumen forms a ring, as no coronary tree does", "near " + place(*where),
                     "Euler number " +
                         std::to_string(static_cast<long>(mesh.number_of_vertices() + mesh.number_of_faces()) -
                                        static_cast<long>(mesh.number_of_edges())),
                     "separate the vessels that touch there, or fill the hole through the lumen");
}

// Which end is which: as in the earlier state, by the given caps, by the given points, or by size.
Naming named(std::vector<End>& ends, const Options& options, const std::optional<nlohmann::json>& like) {
  if (like)
    return naming_like(ends, *like);
  if (options.caps.empty())
    return naming_given(ends, options.inlet, options.outlets);
  std::vector<Vec3> centres;
  for (const GivenCap& cap : read_caps(options.caps, options.units))
    centres.push_back(cap.centre);
  return naming_given(ends, centres.front(), {centres.begin() + 1, centres.end()});
}

// Whether the wanted edge may already be there: tagged, closed and of about as many triangles, as an earlier state is.
bool may_be_kept(const Options& options, const Prepared& prepared, bool tagged) {
  const double triangles = PMP::area(prepared.given) / (std::sqrt(3.0) / 4 * options.edge * options.edge);
  return tagged && !options.like.empty() && static_cast<double>(prepared.given.number_of_faces()) < 4 * triangles;
}

std::vector<double> extensions(const Options& options, std::size_t ends, std::size_t inlet) {
  std::vector<double> radii(ends, options.extend_outlets);
  radii[inlet] = options.extend_inlet;
  return radii;
}

// The mesh for the deployment: an earlier state's as far as it still is as wanted, else from the uniform one.
Mesh graded_mesh(const Mesh& mesh, bool kept, const Mesh& surface, const EdgeField& field) {
  if (!kept)
    return graded(mesh, surface, field);
  if (const auto regraded_mesh = regraded(mesh, surface, field))
    return *regraded_mesh;
  return graded(remeshed(surface, field.edge(), surface), surface, field);
}

} // namespace

Prepared prepare(const Options& options, StepTimer& timer) {
  check_options(options);
  Prepared out;
  timer.start("read");
  const std::vector<GivenCap> caps = read_caps(options.caps, options.units);
  out.input = read_surface(options.input, options.units, options.label, out.repairs);
  const Soup soup = soup_of(out.input);
  timer.start("repair");
  out.mesh = repaired(soup, out.repairs);
  region_map(out.mesh);
  if (!soup.region.empty())
    tag_from_soup(out.mesh, soup);
  timer.start("ends");
  cap_open_ends(out.mesh, out.repairs);
  orient_outward(out.mesh, out.repairs);
  timer.start("self-intersections");
  remove_self_intersections(out.mesh, out.repairs);
  timer.start("caps");
  if (!caps.empty())
    tag_given_caps(out.mesh, caps);
  else if (soup.region.empty())
    tag_flat_caps(out.mesh);
  out.ends = measured_ends(out.mesh);
  cut_flat(out, options);
  check_no_handle(out.mesh);
  const double moved = flatten_caps(out.mesh);
  if (moved > 1e-3)
    out.repairs.push_back({"caps flattened", out.ends.size(), "moved up to " + std::to_string(moved) + " mm"});
  check_mean_radius(2 * PMP::volume(out.mesh) / PMP::area(out.mesh), options.units, options.input);
  out.given = out.mesh;
  if (is_coarse(out.mesh))
    out.mesh = curved_refined(out.mesh);
  return out;
}

Anatomy process(const Options& options, StepTimer& timer) {
  std::optional<nlohmann::json> like;
  if (!options.like.empty())
    like = read_like(options.like);
  Prepared prepared = prepare(options, timer);
  Anatomy out;
  out.source_path = options.input;
  out.source_sha256 = sha256_of_file(options.input);
  out.units = options.units;
  out.edge = options.edge;
  out.repairs = prepared.repairs;
  out.ends = prepared.ends;
  const Naming naming = named(out.ends, options, like);
  timer.start("extend");
  prepared.mesh = extended(prepared.mesh, out.ends, extensions(options, out.ends.size(), naming.inlet));
  timer.start("remesh");
  const bool extends = options.extend_inlet > 0 || options.extend_outlets > 0;
  const Mesh& coarse = extends ? prepared.mesh : prepared.given; // which is the faster to remesh
  const bool kept = !extends && may_be_kept(options, prepared, prepared.input->GetCellData()->HasArray("region_id"));
  out.mesh = kept ? prepared.given : remeshed(coarse, options.edge, prepared.mesh);
  timer.start("centreline");
  const std::vector<Path> paths = voronoi_paths(out.mesh, out.ends, naming.inlet);
  const WallTree wall(prepared.mesh);
  const std::vector<End> before = out.ends;
  out.branches = build_tree(paths, out.ends, naming.inlet, wall, options.spacing, naming.branch);
  retag(out.mesh, out.ends, before);
  timer.start("sections");
  out.sections = cut_sections(prepared.mesh, out.branches, out.ends);
  timer.start("lesions");
  out.profiles = reference_profiles(out.branches, out.sections, out.repairs);
  out.lesions = find_lesions(out.branches, out.sections, out.profiles);
  timer.start("grade");
  retag(prepared.mesh, out.ends, before);
  out.mesh = graded_mesh(out.mesh, kept, prepared.mesh, EdgeField(options.edge, out.branches, out.profiles));
  out.quality = quality_of(out.mesh);
  timer.start("arrays");
  out.arrays = arrays_of(out.mesh, out.branches, out.profiles, prepared.input);
  return out;
}

} // namespace anatomy
