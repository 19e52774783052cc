// The program vci: deploy, radius-correct, inflate, crush, settings.
#include "common/command_line.hpp"
#include "common/error.hpp"
#include "common/processor.hpp"
#include "vci/bench/bench.hpp"
#include "vci/bench/crush.hpp"
#include "vci/procedure/diagnostics.hpp"
#include "vci/procedure/radius_correction.hpp"
#include "vci/results/carried_lumen.hpp"
#include "vci/results/frames.hpp"
#include "vci/results/output.hpp"
#include "vci/results/readouts.hpp"
#include "vci/results/strut_pattern.hpp"
#include "vci/scene/checks/lumen_check.hpp"
#include "vci/scene/checks/plausibility.hpp"
#include "vci/scene/files/centreline_file.hpp"
#include "vci/scene/files/scene_file.hpp"
#include "vci/scene/files/settings.hpp"

#include <chrono>
#include <limits>

namespace {

namespace fs = std::filesystem;
using namespace vci;

PointArray displacement_array(const Lumen& lumen, const Vectors& points) {
  Vectors moved = points;
  for (std::size_t i = 0; i < points.size(); ++i)
    moved[i] -= lumen.points[i];
  return vector_array("displacement_mm", moved);
}

/// Reads the scene. If the scene is refused, an earlier run's deployment.json is removed from `out`, so that nobody
/// takes it for the result of this run.
Scene read_scene_for_output(const fs::path& scene_file, const fs::path& out) {
  try {
    return read_scene(scene_file);
  } catch (...) {
    remove_stale_result(out, scene_file);
    throw;
  }
}

int run_deploy(const fs::path& scene_file, const fs::path& out, const fs::path& frames, int every_steps) {
  const Scene scene = read_scene_for_output(scene_file, out);
  const OutputFolder output(out, {scene_file, scene.lumen, scene.coarse_lumen, scene.centreline});
  const LumenFile lumen = read_lumen(scene.lumen);
  const auto paths = read_centreline(scene.centreline);
  check_placements(scene, paths);
  check_lumen(scene, lumen, paths);
  LumenFile deployed = lumen;
  std::optional<CarriedLumen> carried;
  if (!scene.coarse_lumen.empty()) {
    Scene coarse_scene = scene;
    coarse_scene.lumen = scene.coarse_lumen; // for the messages of the check
    deployed = read_lumen(scene.coarse_lumen);
    carried.emplace(deployed, lumen, scene.coarse_lumen.string());
    check_lumen(coarse_scene, deployed, paths);
  }
  std::optional<FrameWriter> writer;
  Observer observer{{}, every_steps, [](const std::string& line) { std::cerr << line << '\n'; }};
  if (!frames.empty()) {
    writer.emplace(frames, deployed);
    observer.see = [&](const Snapshot& snapshot) { writer->add(snapshot); };
  }
  DeploymentResult d = deploy(scene, deployed, paths, observer);
  if (writer)
    writer->finish();
  std::vector<PointArray> arrays = force_arrays(d.forces);
  if (carried) {
    write_shape(output.folder() / "coarse_lumen.vtp", d.points, deployed.triangles, {}, arrays);
    d = carried->carried(std::move(d));
    arrays.clear();
  }
  arrays.push_back(displacement_array(lumen, d.points));
  arrays.push_back({"wall_stretch", 1, d.wall_stretch});
  arrays.push_back({"malapposition_mm", 1, d.malapposition});
  write_lumen(output.folder() / "lumen.vtp", output.folder() / "lumen.stl", lumen, d.points, arrays);
  std::size_t stent = 0;
  for (const DeviceShape& shape : d.devices) {
    const bool is_stent = shape.kind == DeviceShape::Kind::stent;
    const std::string name = is_stent ? "stent" + std::to_string(stent + 1) : shape.name;
    write_shape(output.folder() / "devices" / (name + ".vtp"), shape.points, shape.triangles, {},
                force_arrays(shape.forces));
    if (is_stent) {
      const Struts struts = strut_pattern(scene.stents.at(shape.name), d.stents[stent].stent.grid, shape.points);
      write_shape(output.folder() / "devices" / (name + "_struts.vtp"), struts.points, struts.triangles, struts.lines,
                  {});
      ++stent;
    }
  }
  const nlohmann::json document = readouts(scene, lumen, paths, d);
  for (std::size_t k = d.warnings.size(); k < document["warnings"].size(); ++k) // deploy() has printed the earlier ones
    observer.log("warning: " + document["warnings"][k].get<std::string>());
  write_json(output.folder() / "deployment.json", document);
  output.publish();
  return 0;
}

int run_radius_correct(const fs::path& scene_file, const fs::path& out) {
  const Scene scene = read_scene_for_output(scene_file, out);
  const OutputFolder output(out, {scene_file, scene.lumen, scene.centreline});
  const LumenFile lumen = read_lumen(scene.lumen);
  const auto paths = read_centreline(scene.centreline);
  check_placements(scene, paths);
  check_lumen(scene, lumen, paths);
  const auto start = std::chrono::steady_clock::now();
  const Vectors points = correct_radius(scene, lumen, paths);
  write_lumen(output.folder() / "lumen.vtp", output.folder() / "lumen.stl", lumen, points,
              {displacement_array(lumen, points)});
  const Segment segment = reported_segment(scene);
  const Path& path = paths.at(segment.branch);
  const nlohmann::json profile = area_profile(points, lumen.triangles, path, segment.s_start, segment.s_end);
  write_json(output.folder() / "deployment.json",
             {{"schema", "vci-deployment-1"},
              {"case", scene.case_name},
              {"status", "radius set"},
              {"method", "radius-correct"},
              {"stages", nlohmann::json::array()},
              {"settings", scene.settings},
              {"seconds", std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()},
              {"switched_off", {"mechanics: the radius is set, the axis kept"}},
              {"warnings", warnings_of_plan(scene)},
              {"segment", {{"branch", segment.branch}, {"s_start_mm", segment.s_start}, {"s_end_mm", segment.s_end}}},
              {"csa_profile", profile},
              {"minimal_lumen_area_mm2", smallest_area(profile)}});
  output.publish();
  return 0;
}

int run_inflate(const fs::path& scene_file, const std::string& device, int wings) {
  const Scene scene = read_scene(scene_file);
  if (!scene.balloons.contains(device))
    throw common::InputError("no such balloon in the scene", scene_file.string() + ": devices", device,
                             "name an entry with kind balloon");
  BalloonSpec spec = scene.balloons.at(device);
  if (wings > 0) {
    spec.folding = spec.folding.value_or(FoldingSpec{});
    spec.folding->wings = wings;
  }
  std::cout << "pressure_bar,chart_diameter_mm,diameter_mm,length_mm,residual,steps\n";
  for (const InflationPoint& p : inflate(spec, scene.numerics, spec.chart_pressure_bar))
    std::cout << p.pressure_bar << ',' << p.chart_diameter_mm << ',' << p.diameter_mm << ',' << p.length_mm << ','
              << p.residual << ',' << p.steps << '\n';
  return 0;
}

int run_crush(const fs::path& scene_file, const std::string& device) {
  const Scene scene = read_scene(scene_file);
  if (!scene.stents.contains(device))
    throw common::InputError("no such stent in the scene", scene_file.string() + ": devices", device,
                             "name an entry with kind stent");
  const StentSpec& spec = scene.stents.at(device);
  const CrushTest test = crush(spec, scene.balloon(device), scene.numerics);
  std::cout << "diameter_loss_percent,pressure_mpa,inflated_diameter_mm,free_diameter_mm,recoil_percent,residual\n";
  for (const CrushPoint& p : test.points)
    std::cout << p.loss_percent << ',' << p.pressure_mpa << ',' << test.inflated_diameter << ',' << test.free_diameter
              << ',' << test.recoil_percent << ',' << test.residual << '\n';
  return 0;
}

} // namespace

int main(int argc, char** argv) {
  common::restart_without_fma(argv);
  CLI::App app{"Virtual coronary intervention: what balloon and stent do to a narrowed artery", "vci"};
  app.require_subcommand(1);
  std::string scene, out, device, frames;
  int every_steps = 0, wings = 0;
  bool as_json = false;
  CLI::App* deploy_command = app.add_subcommand("deploy", "run a scene's procedure");
  CLI::App* correct_command = app.add_subcommand("radius-correct", "the baseline: set the radius to the device's");
  for (CLI::App* command : {deploy_command, correct_command}) {
    command->add_option("scene", scene, "scene.json")->required();
    command->add_option("--out", out, "folder for lumen, devices and deployment.json")->required();
  }
  CLI::App* inflate_command = app.add_subcommand("inflate", "free expansion of a balloon against its chart, CSV");
  inflate_command->add_option("scene", scene, "scene.json that defines the balloon")->required();
  inflate_command->add_option("--device", device, "key under devices")->required();
  inflate_command->add_option("--wings", wings, "fold the balloon into so many wings first")->check(CLI::Range(2, 6));
  CLI::Option* folder =
      deploy_command->add_option("--frames", frames, "folder for the state at each stage's end, with frames.pvd");
  deploy_command->add_option("--frames-every", every_steps, "and after every so many steps")
      ->check(CLI::Range(1, std::numeric_limits<int>::max()))
      ->needs(folder);
  CLI::App* crush_command = app.add_subcommand("crush", "radial strength and free recoil of a stent on the bench, CSV");
  crush_command->add_option("scene", scene, "scene.json that defines the stent and its balloon")->required();
  crush_command->add_option("--device", device, "key under devices")->required();
  CLI::App* settings_command = app.add_subcommand("settings", "every setting of a scene's wall and numerics");
  settings_command->add_flag("--json", as_json, "as the properties of a JSON schema")->required();
  if (const auto code = common::exit_code_of_parsing(app, argc, argv))
    return *code;
  return common::guarded([&] {
    if (*deploy_command)
      return run_deploy(scene, out, frames, every_steps);
    if (*correct_command)
      return run_radius_correct(scene, out);
    if (*settings_command) {
      std::cout << settings_table().dump(1) << '\n';
      return 0;
    }
    if (*crush_command)
      return run_crush(scene, device);
    return run_inflate(scene, device, wings);
  });
}
