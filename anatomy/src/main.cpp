// The program lumen: any lumen surface in, trustworthy geometry out.
#include "common/error.hpp"
#include "process.hpp"
#include "surface_file.hpp"
#include <CLI/CLI.hpp>
#include <iostream>

namespace {

using namespace anatomy;

void add_input(CLI::App& command, Options& options) {
  command.add_option("surface", options.input, "lumen surface: .stl, .vtp, .ply or .obj")->required();
  command.add_option("--units", options.units, "length unit of the file: mm, cm or m")->capture_default_str();
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

void check(const Options& options) {
  StepTimer timer;
  const Prepared prepared = prepare(options, timer);
  for (const Repair& repair : prepared.repairs)
    std::cout << "repair: " << repair.what << " (" << repair.count << ") " << repair.detail << '\n';
  for (const End& end : prepared.ends)
    std::cout << "end: radius " << end.radius() << " mm at " << place(end.centre) << '\n';
}

} // namespace

int main(int argc, char** argv) {
  CLI::App app{"lumen: checks, repairs, remeshes and measures a coronary lumen surface (lengths in mm)"};
  app.require_subcommand(1);
  Options options;
  std::string out;
  std::vector<double> inlet, outlets;

  auto* process_command =
      app.add_subcommand("process", "surface to lumen.vtp, centreline.vtp, sections.csv, anatomy.json");
  add_input(*process_command, options);
  process_command->add_option("--edge", options.edge, "edge length of the new surface, mm")->capture_default_str();
  process_command->add_option("--spacing", options.spacing, "distance between cross-sections, mm")
      ->capture_default_str();
  process_command->add_option("--inlet", inlet, "a point near the inlet, x,y,z in mm; default: the largest end")
      ->delimiter(',')
      ->expected(3);
  process_command->add_option("--outlet", outlets, "a point near an outlet, x,y,z in mm; repeat for each, main's first")
      ->delimiter(',');
  process_command->add_option("--like", options.like, "anatomy.json of an earlier state, whose names the ends take");
  process_command->add_option("--out", out, "folder for the results")->required();

  auto* check_command = app.add_subcommand("check", "print the repairs a surface needs and the ends it has");
  add_input(*check_command, options);

  auto* remesh_command = app.add_subcommand("remesh", "repaired, capped, uniform surface with region_id");
  add_input(*remesh_command, options);
  remesh_command->add_option("--edge", options.edge, "edge length, mm")->capture_default_str();
  remesh_command->add_option("--out", out, "surface to write: .vtp or .stl")->required();

  CLI11_PARSE(app, argc, argv);
  return common::guarded([&] {
    if (inlet.size() == 3)
      options.inlet = Vec3(inlet[0], inlet[1], inlet[2]);
    if (outlets.size() % 3 != 0)
      throw common::InputError("an outlet point has three coordinates", "--outlet",
                               std::to_string(outlets.size()) + " numbers", "write --outlet x,y,z for each outlet");
    for (std::size_t i = 0; i < outlets.size(); i += 3)
      options.outlets.emplace_back(outlets[i], outlets[i + 1], outlets[i + 2]);
    if (check_command->parsed()) {
      check(options);
    } else if (remesh_command->parsed()) {
      StepTimer timer;
      write_surface(remeshed(prepare(options, timer).mesh, options.edge), out);
    } else {
      StepTimer timer;
      const Anatomy anatomy = process(options, timer);
      timer.stop();
      write_anatomy(anatomy, timer, out);
      print_summary(anatomy, timer);
    }
    return 0;
  });
}
