// A balloon in a narrowed artery, step by step: deploy LUMEN.vtp CENTRELINE.vtp prints areas before and after.
#include "vci/files.hpp"

int main(int, char** argv) {
  const vci::LumenFile lumen = vci::read_lumen(argv[1]);
  const auto paths = vci::read_centreline(argv[2]);
  vci::Scene scene;
  scene.balloons["nc"] = {.nominal_diameter = 3,
                          .length = 8,
                          .crimped_diameter = 0.9,
                          .rated_burst_pressure_bar = 18,
                          .chart_pressure_bar = {4, 8, 12, 18},
                          .chart_diameter = {2.88, 3, 3.06, 3.15}};
  scene.procedure = {{"predilatation", vci::Action::predilatation, {{"nc", "main", paths.at("main").end() / 2, 12}}}};
  vci::check_lumen(scene, lumen, paths);
  vci::Deployment deployment(scene, lumen, paths, {.log = [](const std::string& line) { std::cerr << line << '\n'; }});
  deployment.step();
  for (const vci::Vectors& points : {lumen.points, deployment.lumen()})
    std::cout << vci::smallest_section(points, lumen.triangles, paths.at("main"), 1, paths.at("main").end() - 1)
              << '\n';
}
