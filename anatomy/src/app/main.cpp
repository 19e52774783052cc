// The program lumen: checks, repairs, remeshes and measures a coronary lumen surface.
#include "app/inlet_warnings.hpp"
#include "app/process.hpp"
#include "app/vtk_output.hpp"
#include "common/command_line.hpp"
#include "common/processor.hpp"
#include "files/surface_file.hpp"
#include "trees/naming.hpp"
#include "trees/table.hpp"
#include <algorithm>
#include <cmath>
#include <iostream>
#include <regex>
#include <vtkObject.h>

namespace {

using namespace anatomy;

const std::string whole_model = "whole"; // the --tree of a model with an aorta that is taken as it is

// What the command line gives before it is converted. Points (mm) are three coordinates each, one point after the
// other.
struct Given {
  std::vector<double> inlet, outlets, cuts, ostium;
  std::string units = text_of(LengthUnit::mm), tree;
};

std::vector<Vec3> given_points(const std::vector<double>& coordinates, const std::string& option) {
  if (coordinates.size() % 3 != 0)
    throw common::InputError("a point has three coordinates", option, std::to_string(coordinates.size()) + " numbers",
                             "write " + option + " x,y,z for each point");
  std::vector<Vec3> points;
  if (!std::all_of(coordinates.begin(), coordinates.end(), [](double x) { return std::isfinite(x); }))
    throw common::InputError("a coordinate is no number", option, "nan or inf", "write " + option + " x,y,z in mm");
  for (std::size_t i = 0; i < coordinates.size(); i += 3)
    points.emplace_back(coordinates[i], coordinates[i + 1], coordinates[i + 2]);
  return points;
}

void add_input(CLI::App& command, Options& options, Given& given) {
  command
      .add_option("surface", options.input,
                  "lumen surface (.stl, .vtp, .ply, .obj) or labelled mask (.nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd)")
      ->required();
  command.add_option("--units", given.units, "length unit of the file: mm, cm or m")->capture_default_str();
  command
      .add_option("--label", options.labels,
                  "the lumen's label in a mask, or the labels of all its branches, as 1,2; default: the only one")
      ->delimiter(',')
      ->check([](const std::string& label) { return std::string(label == "0" ? "0 is what is no vessel" : ""); });
  command.add_option("--cut", given.cuts, "cut the vessel flat across at its axis near x,y,z (mm); repeat for each")
      ->delimiter(',');
  command.add_option(
      "--cap", options.caps,
      "file with the triangles of one end; repeat for each: the inlet's, then the outlets', main's first");
  command
      .add_option("--tree", given.tree,
                  "the coronary tree of a model with an aorta: left, right, tree1, ...; whole: take it as it is")
      ->check([](const std::string& name) {
        static const std::regex known("left|right|tree[1-9][0-9]*");
        return std::string(
            name == whole_model || std::regex_match(name, known) ? "" : "give left, right, tree1, tree2, ... or whole");
      });
  command.add_option("--ostium", given.ostium, "where that tree leaves the aorta, x,y,z in mm")
      ->delimiter(',')
      ->expected(3);
  command.add_flag("--close-others", options.close_others, "close openings that no --inlet, --outlet or --cap names");
  command.add_option("--inlet", given.inlet, "a point near the inlet, x,y,z in mm; default: the largest end")
      ->delimiter(',')
      ->expected(3);
  command.add_option("--outlet", given.outlets, "a point near an outlet, x,y,z in mm; repeat for each, main's first")
      ->delimiter(',');
}

void print_summary(const Anatomy& anatomy, const StepTimer& timer) {
  nlohmann::ordered_json all = summary(anatomy, timer);
  for (const auto& repair : all["repairs"])
    std::cerr << "lumen: repair: " << repair["what"].get<std::string>() << " (" << repair["count"] << ") "
              << repair["detail"].get<std::string>() << '\n';
  std::printf("%zu ends, %zu branches, %zu sections, %zu lesions, %zu triangles, smallest angle %.1f deg\n",
              anatomy.ends.size(), anatomy.branches.size(), anatomy.sections.size(), anatomy.lesions.size(),
              static_cast<std::size_t>(anatomy.mesh.number_of_faces()), anatomy.quality.min_angle_deg);
}

// The coronary trees whose ends `lumen check` shows: the one that the user chose, else all. If there is no aorta, the
// list has one null pointer, for the whole surface.
std::vector<const CoronaryTree*> trees_to_check(const ClosedSurface& closed, const Options& options) {
  if (!closed.aorta)
    return {nullptr};
  const TreeChoice choice = tree_choice_of(options);
  if (choice.is_given() || !choice.outlets.empty())
    return {&choose_tree(*closed.aorta, choice)};
  std::vector<const CoronaryTree*> trees;
  for (const CoronaryTree& tree : closed.aorta->trees)
    trees.push_back(&tree);
  return trees;
}

// A line of text with the end that becomes the inlet, and why. It is empty if the file's own tags name the inlet, or if
// there are fewer than two ends.
std::string inlet_line(const PreparedLumen& prepared) {
  if (prepared.ends.size() < 2 || tagged_inlet(prepared.input))
    return "";
  std::vector<End> ends = prepared.ends;
  End& inlet = ends[inlet_of(ends, prepared.named.inlet)];
  inlet.inlet = true;
  char line[160];
  std::snprintf(line, sizeof line, "inlet: %s, diameter %.2f mm, %s\n", point_text(inlet.centre).c_str(),
                2 * inlet.radius(),
                prepared.named.inlet ? "named" : "since it is the largest end; --inlet names another");
  const std::string doubt = prepared.named.inlet ? "" : wide_end_doubt(ends);
  return line + (doubt.empty() ? "" : "warning: the inlet is chosen by its width alone: " + doubt + "\n");
}

void check(const Options& options, const std::string& repaired, const std::string& ends) {
  if (!repaired.empty())
    check_surface_file(repaired);
  if (!ends.empty())
    check_folder_of(ends);
  StepTimer timer;
  const ClosedSurface closed = closed_surface(options, timer);
  const std::vector<const CoronaryTree*> trees = trees_to_check(closed, options);
  std::vector<EndCandidate> candidates;
  std::vector<TreeEntry> tree_entries;
  std::set<std::string> printed;
  Mesh mesh = closed.mesh;
  for (const CoronaryTree* tree : trees) {
    const PreparedLumen prepared = find_lumen_ends(closed, tree, options, timer);
    print_warnings(prepared.repairs, 0);
    for (const Repair& repair : prepared.repairs) {
      const std::string line = "repair: " + repair.what + " (" + std::to_string(repair.count) + ") " + repair.detail;
      if (printed.insert(line).second)
        std::cout << line << '\n';
    }
    std::copy_if(prepared.candidates.begin(), prepared.candidates.end(), std::back_inserter(candidates),
                 [&](const EndCandidate& one) { return one.is_end || trees.size() == 1; });
    for (const std::string& line : {area_error_line(prepared.voxels), tree ? std::string() : inlet_line(prepared)})
      if (printed.insert(line).second)
        std::cout << line;
    if (tree)
      tree_entries.push_back({*tree, prepared.ends.size() - 1});
    if (trees.size() == 1)
      mesh = prepared.unrefined;
  }
  std::cout << table_of(candidates) << table_of(tree_entries, closed.aorta);
  nlohmann::ordered_json document = document_of(candidates);
  document["trees"] = document_of(tree_entries);
  if (!ends.empty()) {
    make_folder_of(ends);
    write_text(ends, document.dump(1) + "\n");
  }
  if (!repaired.empty())
    write_surface(mesh, repaired);
}

} // namespace

int main(int argc, char** argv) {
  common::restart_without_fma(argv);
  CLI::App app{"lumen: checks, repairs, remeshes and measures a coronary lumen surface (lengths in mm)", "lumen"};
  app.require_subcommand(1);
  Options options;
  std::string out;
  Given given;

  auto* process_command =
      app.add_subcommand("process", "surface to lumen.vtp, centreline.vtp, sections.csv, anatomy.json");
  add_input(*process_command, options, given);
  process_command->add_option("--edge", options.edge, "edge length of the new surface, mm")->capture_default_str();
  process_command->add_option("--spacing", options.spacing, "distance between cross-sections, mm")
      ->capture_default_str();
  process_command->add_option("--extend-inlet", options.extend_inlet, "straight extension of the inlet, in its radii");
  process_command->add_option("--extend-outlets", options.extend_outlets,
                              "straight extension of every outlet, in its radii");
  process_command->add_option("--like", options.like, "anatomy.json of an earlier state, whose names the ends take");
  process_command->add_option("--out", out, "folder for the results")->required();

  auto* check_command = app.add_subcommand("check", "print the repairs a surface needs and the ends it has");
  add_input(*check_command, options, given);
  std::string repaired;
  check_command->add_option("--repaired", repaired, "repaired, capped surface to write: .vtp or .stl; default: none");

  std::string ends;
  check_command->add_option("--ends", ends, "what was taken for ends and why, as JSON for `anatomy ends`");

  auto* remesh_command = app.add_subcommand("remesh", "repaired, capped, uniform surface with region_id");
  add_input(*remesh_command, options, given);
  remesh_command->add_option("--edge", options.edge, "edge length, mm")->capture_default_str();
  remesh_command->add_option("--out", out, "surface to write: .vtp or .stl")->required();

  vtkObject::GlobalWarningDisplayOff(); // VTK prints nothing; InputError reports what a reader cannot read
  if (const auto code = common::exit_code_of_parsing(app, argc, argv))
    return *code;
  return common::guarded([&] {
    if (!given.inlet.empty())
      options.inlet = given_points(given.inlet, "--inlet").front();
    if (!given.ostium.empty())
      options.ostium = given_points(given.ostium, "--ostium").front();
    options.outlets = given_points(given.outlets, "--outlet");
    options.cuts = given_points(given.cuts, "--cut");
    options.unit = length_unit_of(given.units);
    options.whole = given.tree == whole_model;
    options.tree = options.whole ? "" : given.tree;
    if (check_command->parsed()) {
      check(options, repaired, ends);
    } else if (remesh_command->parsed()) {
      check_surface_file(out);
      StepTimer timer;
      const PreparedLumen prepared = prepare(options, timer);
      write_surface(remeshed(prepared.unrefined, options.edge, prepared.mesh), out);
    } else {
      check_folder(out);
      StepTimer timer;
      const Anatomy anatomy = process(options, timer);
      timer.stop();
      write_anatomy(anatomy, timer, out);
      print_summary(anatomy, timer);
    }
    return 0;
  });
}
