#include "app/process.hpp"
#include "app/checks.hpp"
#include "app/inlet_warnings.hpp"
#include "common/error.hpp"
#include "core/measures.hpp"
#include "ends/ends.hpp"
#include "ends/extend.hpp"
#include "files/surface_file.hpp"
#include "measure/end_zones.hpp"
#include "measure/fused_vessels.hpp"
#include "measure/section_noise.hpp"
#include "measure/steep_taper.hpp"
#include "remesh/grading.hpp"
#include "trees/naming.hpp"
#include <array>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <regex>
#include <vtkCellData.h>

namespace anatomy {
namespace {

using common::InputError;

constexpr double finest_trial_edge = 0.05;      // mm, shortest edge of a mesh that is tried for the axes
constexpr double most_trial_triangles = 250000; // largest number of triangles of such a mesh, which takes some 20 s

// Whether a mesh of this edge (mm) may be tried after one of longer edges has failed.
bool can_try_edge(double edge, const Mesh& surface) {
  return edge >= finest_trial_edge && surface_area(surface) / (std::sqrt(3.0) / 4 * edge * edge) < most_trial_triangles;
}

// Reads the anatomy.json of an earlier state. Throws InputError if a value of its ends that is used later is missing or
// invalid.
nlohmann::json read_earlier_state(const std::string& path) {
  std::ifstream file(path);
  if (!file)
    throw InputError("no such file", path, "missing", "give the anatomy.json of the earlier state");
  try {
    nlohmann::json like = nlohmann::json::parse(file);
    if (like.at("schema") != "vci-anatomy-1")
      throw InputError("not an anatomy summary", path, "no schema vci-anatomy-1", "give an anatomy.json");
    for (const nlohmann::json& end : like.at("ends")) {
      static_cast<void>(end.at("centre_mm").get<std::array<double, 3>>());
      static_cast<void>(end.at("name").get<std::string>());
      static_cast<void>(end.value("extension_mm", 0.0));
      static const std::regex known("main|side[1-9][0-9]{0,3}");
      if (end.at("kind").get<std::string>() != "inlet" && !std::regex_match(end.at("branch").get<std::string>(), known))
        throw InputError("an end of no known branch", path, end.at("branch").dump(), "main, side1, side2, ...");
    }
    return like;
  } catch (const nlohmann::json::exception& e) {
    throw InputError("not an anatomy summary", path, e.what(),
                     "give the anatomy.json of the earlier state, as written");
  }
}

// Gives the caps the tags of `ends`, which follow the branches of the tree. Until now they have the tags of `before`,
// the same ends numbered by area.
void retag(Mesh& mesh, const std::vector<End>& ends, const std::vector<End>& before) {
  RegionMap region = region_map(mesh);
  for (Face f : mesh.faces())
    for (std::size_t e = 0; e < ends.size(); ++e)
      if (region[f] == before[e].region) {
        region[f] = ends[e].region;
        break;
      }
}

// The centre (mm) of the end nearest to the inlet that the file's own tags name, or nothing without such tags. A cut
// may have moved the inlet along the vessel.
std::optional<Vec3> inlet_by_tag(const std::vector<End>& ends, vtkPolyData* input) {
  const std::optional<Vec3> tagged = tagged_inlet(input);
  if (!tagged || ends.empty())
    return std::nullopt;
  return std::min_element(
             ends.begin(), ends.end(),
             [&](const End& a, const End& b) { return (a.centre - *tagged).norm() < (b.centre - *tagged).norm(); })
      ->centre;
}

// Decides which end is the inlet and which branch leads to each outlet. It follows the earlier state if there is one,
// else the caps or points of the user, else the file's tags, else the ends' size.
Naming choose_naming(std::vector<End>& ends, const NamedEnds& given, const std::optional<nlohmann::json>& like,
                     vtkPolyData* input) {
  if (like)
    return naming_from_earlier(ends, *like);
  return naming_from_points(ends, given.inlet ? given.inlet : inlet_by_tag(ends, input), given.outlets);
}

// Whether the given mesh may have the wanted edge length already. This needs an earlier state, tags of the caps
// (`tagged`), and fewer than four times the triangles expected at that edge length.
bool may_keep_mesh(const Options& options, const PreparedLumen& prepared, bool tagged) {
  const double triangles = surface_area(prepared.unrefined) / (std::sqrt(3.0) / 4 * options.edge * options.edge);
  return tagged && !options.like.empty() && static_cast<double>(prepared.unrefined.number_of_faces()) < 4 * triangles;
}

// The extension of each end, in radii of the end.
std::vector<double> extensions(const Options& options, std::size_t ends, std::size_t inlet) {
  std::vector<double> radii(ends, options.extend_outlets);
  radii[inlet] = options.extend_inlet;
  return radii;
}

// The mesh whose inscribed spheres give the axes, and the paths through these spheres.
struct AxisMesh {
  Mesh mesh;
  double edge; ///< mm, edge length of the mesh
  std::vector<Path> paths;
};

// Remeshes to the wanted edge length and finds the paths. If that edge is too long to follow the lumen through a
// narrowing, it is halved, as often as can_try_edge allows.
AxisMesh find_axis_mesh(const Mesh& coarse, const PreparedLumen& prepared, const Options& options, std::size_t inlet,
                        StepTimer& timer) {
  for (double edge = options.edge;; edge /= 2)
    try {
      timer.start("remesh");
      Mesh mesh = remeshed(coarse, edge, prepared.mesh);
      timer.start("centreline");
      std::vector<Path> paths = voronoi_paths(mesh, prepared.ends, inlet);
      return {std::move(mesh), edge, std::move(paths)};
    } catch (const common::ComputationError&) {
      if (!can_try_edge(edge / 2, prepared.mesh))
        throw;
    }
}

// Makes the edges of the uniform mesh as long as `field` asks. If this fails, for example because a throat closes, the
// function starts from finer meshes: of half the edge, a quarter, and so on.
Mesh graded_with_retries(const AxisMesh& axis_mesh, const Mesh& surface, const SizingField& field) {
  for (double edge = axis_mesh.edge;; edge /= 2)
    try {
      if (edge >= field.edge())
        return graded(axis_mesh.mesh, surface, field);
      return coarsened(edge == axis_mesh.edge ? axis_mesh.mesh : remeshed(surface, edge, surface), edge, surface,
                       field);
    } catch (const common::ComputationError&) {
      if (!can_try_edge(edge / 2, surface))
        throw;
    }
}

// The final mesh. If `kept`, the given mesh is remeshed only where its edges no longer have the wanted length or its
// angles are small. Both states then share most of their triangles. Otherwise, or if too much of it would change, the
// mesh is made anew.
Mesh graded_mesh(const AxisMesh& axis_mesh, bool kept, const Mesh& surface, const SizingField& field) {
  if (!kept)
    return graded_with_retries(axis_mesh, surface, field);
  if (const auto regraded_mesh = regraded(axis_mesh.mesh, surface, field))
    return *regraded_mesh;
  return graded_with_retries({remeshed(surface, field.edge(), surface), field.edge(), {}}, surface, field);
}

} // namespace

Anatomy process(const Options& options, StepTimer& timer) {
  std::optional<nlohmann::json> like;
  if (!options.like.empty())
    like = read_earlier_state(options.like);
  PreparedLumen prepared = prepare(options, timer);
  Anatomy out;
  out.source_path = options.input;
  out.source_sha256 = sha256_of_file(options.input);
  out.unit = options.unit;
  out.edge = options.edge;
  out.repairs = prepared.repairs;
  out.ends = prepared.ends;
  check_ends_seen(prepared.mesh, prepared.ends);
  const Naming naming = choose_naming(out.ends, prepared.named, like, prepared.input);
  timer.start("extend");
  prepared.mesh = extended(prepared.mesh, out.ends, extensions(options, out.ends.size(), naming.inlet));
  const bool extends = options.extend_inlet > 0 || options.extend_outlets > 0;
  const Mesh& coarse = extends ? prepared.mesh : prepared.unrefined; // the unrefined lumen is remeshed faster
  const bool kept = !extends && may_keep_mesh(options, prepared, prepared.input->GetCellData()->HasArray("region_id"));
  prepared.ends = out.ends; // the ends with their extensions
  if (kept)
    timer.start("centreline");
  AxisMesh axis_mesh =
      kept ? AxisMesh{prepared.unrefined, options.edge, voronoi_paths(prepared.unrefined, out.ends, naming.inlet)}
           : find_axis_mesh(coarse, prepared, options, naming.inlet, timer);
  const WallTree wall(prepared.mesh);
  const std::vector<End> before = out.ends;
  out.branches = build_tree(axis_mesh.paths, out.ends, naming.inlet, wall, options.spacing, naming.branch);
  retag(axis_mesh.mesh, out.ends, before);
  std::size_t reported = out.repairs.size();
  if (!like && !prepared.named.inlet && !tagged_inlet(prepared.input))
    warn_of_doubtful_inlet(out.ends, out.branches, out.repairs);
  else if (!like)
    warn_of_narrow_inlet(out.ends, out.repairs);
  warn_of_turning_back(out.branches, out.repairs);
  timer.start("sections");
  const std::vector<ClosedStub> stubs = closed_stubs(out.branches, stub_tips(prepared.unrefined, before));
  out.sections = cut_sections(prepared.mesh, out.branches, out.ends, prepared.splits, stubs);
  smooth_noisy_areas(out.branches, out.sections, out.repairs);
  timer.start("lesions");
  out.profiles = reference_profiles(out.branches, out.sections, out.repairs, stubs);
  out.lesions = find_lesions(out.branches, out.sections, out.profiles);
  note_steep_tapers(out.branches, out.sections, out.profiles, out.repairs);
  note_wide_ends(out.branches, out.profiles, out.lesions, out.repairs);
  note_narrow_ends(out.branches, out.sections, out.profiles, out.repairs);
  set_area_errors(out.lesions, prepared.voxels);
  note_fused_vessels(out.branches, out.sections, out.profiles, out.repairs);
  note_few_voxels(out.branches, out.sections, out.lesions, prepared.voxels, out.repairs);
  print_warnings(out.repairs, reported);
  timer.start("grade");
  retag(prepared.mesh, out.ends, before);
  out.mesh = graded_mesh(axis_mesh, kept, prepared.mesh, SizingField(options.edge, out.branches, out.profiles));
  out.quality = quality_of(out.mesh);
  reported = out.repairs.size();
  warn_of_small_angle(out.repairs, out.quality);
  print_warnings(out.repairs, reported);
  timer.start("arrays");
  out.arrays = lumen_arrays(out.mesh, out.branches, out.profiles, prepared.input);
  return out;
}

} // namespace anatomy
