// Each kind of bad scene is refused with its key; defaults are filled in.
#include "common/error.hpp"
#include "vci/scene/files/scene_file.hpp"
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <unistd.h>

namespace {

using namespace vci;
using nlohmann::json;

json good_scene() {
  const json balloon{{"kind", "balloon"},
                     {"nominal_diameter_mm", 3.0},
                     {"length_mm", 12.0},
                     {"shoulder_mm", 1.2},
                     {"crimped_diameter_mm", 0.8},
                     {"nominal_pressure_bar", 8},
                     {"rated_burst_pressure_bar", 14},
                     {"chart", {{"pressure_bar", {2, 8, 14}}, {"diameter_mm", {2.8, 3.0, 3.2}}}}};
  const json stent{{"kind", "stent"},
                   {"nominal_diameter_mm", 3.0},
                   {"length_mm", 12.0},
                   {"crimped_diameter_mm", 1.0},
                   {"maximal_diameter_mm", 4.4},
                   {"strut_thickness_mm", 0.08},
                   {"crowns", 8},
                   {"links", 2},
                   {"balloon", "b"}};
  return {{"schema", "vci-scene-1"},
          {"case", "t"},
          {"lumen", "lumen.vtp"},
          {"centreline", "centreline.vtp"},
          {"patient", {{"map_pa", 12000}}},
          {"devices", {{"b", balloon}, {"s", stent}}},
          {"procedure",
           {{{"name", "p"},
             {"action", "stent"},
             {"devices", {{{"device", "s"}, {"branch", "main"}, {"centre_s_mm", 10.0}, {"pressure_bar", 8}}}}}}}};
}

// A text in a file named after the process, because ctest runs the tests of this source at the same time.
class SceneFile {
public:
  explicit SceneFile(const std::string& text)
      : path_(std::filesystem::path(testing::TempDir()) / ("vci_scene_" + std::to_string(::getpid()) + ".json")) {
    std::ofstream(path_) << text;
  }
  ~SceneFile() { std::filesystem::remove(path_); }
  SceneFile(const SceneFile&) = delete;
  SceneFile& operator=(const SceneFile&) = delete;
  const std::filesystem::path& path() const { return path_; }

private:
  std::filesystem::path path_;
};

Scene read(const json& document) {
  return read_scene(SceneFile(document.dump()).path());
}

std::string refusal(const json& document) {
  try {
    read(document);
  } catch (const common::InputError& e) {
    return e.what();
  }
  return "accepted";
}

TEST(Scene, FillsInDefaults) {
  const Scene scene = read(good_scene());
  EXPECT_EQ(scene.wall.model, WallModel::membrane);
  EXPECT_EQ(scene.numerics.integrator.residual_tolerance, 3e-3);
  EXPECT_DOUBLE_EQ(scene.stents.at("s").hoop_stiffness(), 0.22 * 1.5 / (4.5 / 95.5))
      << "Laplace: radial strength; strain of the recoil";
  const PlaqueSpec& calcium = scene.wall.plaque[3];
  EXPECT_NEAR(calcium.youngs_modulus * calcium.yield_strain, 1.3, 1e-12) << "MPa, by Fujino's slope";
  json rigid = good_scene();
  rigid["wall"]["plaque"]["calcified"]["yield_strain"] = nullptr;
  EXPECT_TRUE(std::isinf(read(rigid).wall.plaque[3].yield_strain)) << "null: never";
  EXPECT_EQ(scene.settings["numerics"]["region_margin_mm"], 6);
  EXPECT_FALSE(scene.balloons.at("b").folding.has_value()) << "off unless it is asked for";
  json proposed = good_scene();
  proposed["reference"] = {{"by", "outer wall"}, {"lesions", json::array()}};
  EXPECT_EQ(read(proposed).procedure.size(), scene.procedure.size()) << "what a plan was sized by is passed over";
  json folded = good_scene();
  folded["devices"]["b"]["folding"] = {{"wrap", "clockwise"}};
  const auto folding = read(folded).balloons.at("b").folding;
  ASSERT_TRUE(folding.has_value());
  EXPECT_EQ(folding->wings, 3);
  EXPECT_TRUE(folding->clockwise);
}

TEST(Scene, RefusesBadValuesWithTheirKey) {
  const auto expect = [](const char* pointer, const json& value, const char* part) {
    json d = good_scene();
    d[json::json_pointer(pointer)] = value;
    EXPECT_NE(refusal(d).find(part), std::string::npos) << pointer << ": " << refusal(d);
  };
  expect("/schema", "vci-scene-0", "schema");
  expect("/colour", "red", "unknown key");
  expect("/wall", {{"modell", "membrane"}}, "modell");
  expect("/wall", {{"model", "jelly"}}, "wall.model");
  expect("/wall", {{"poisson_ratio", 0.6}}, "poisson_ratio");
  expect("/numerics", {{"residual_tolerance", 0.5}}, "residual_tolerance");
  expect("/numerics", {{"maximal_steps_per_stage", 2.5}}, "whole number");
  expect("/patient/map_pa", 90, "map_pa");
  expect("/patient/map_pa", "high", "number is expected");
  expect("/devices/s/balloon", "c", "delivery balloon");
  expect("/devices/s/kind", "laser", "kind of device");
  expect("/devices/s/kind", 5, "a text is expected");
  expect("/devices/s", {1, 2}, "an object is expected");
  expect("/devices", {1, 2}, "an object is expected");
  expect("/devices/b/chart/diameter_mm", {2.8, 2.7, 3.2}, "chart");
  expect("/devices/b/folding", {{"wings", 7}}, "folding.wings");
  expect("/devices/b/folding", {{"wrap", "left"}}, "folding.wrap");
  expect("/devices/b/folding", {{"pleats", 3}}, "pleats");
  expect("/devices/b/nominal_pressure_bar", 10, "nominal_pressure_bar"); // the chart has 3.067 mm at 10 bar
  expect("/devices/b/nominal_diameter_mm", 3.04, "contradicts");
  expect("/numerics", {{"fixed_step_ms", 0.02}}, "fixed_step_ms");
  expect("/procedure/0/action", "pray", "action");
  expect("/procedure/0/devices/0/device", "x", "does not define");
  expect("/procedure/0/devices/0/pressure_bar", 39, "burst");
  expect("/procedure", json::array(), "one entry or more");
}

TEST(Scene, RefusesDevicesThatCannotBe) {
  const auto expect = [](const json& changes, const char* part) {
    json d = good_scene();
    for (const auto& [pointer, value] : changes.items())
      d[json::json_pointer(pointer)] = value;
    EXPECT_NE(refusal(d).find(part), std::string::npos) << changes << ": " << refusal(d);
  };
  expect({{"/devices/s/length_mm", 14}, {"/devices/b/length_mm", 6}}, "longer than the balloon");
  expect({{"/devices/s/length_mm", 20}}, "longer than the balloon");
  expect({{"/devices/s/length_mm", 13}}, "accepted"); // half a millimetre longer than the balloon at each end
  expect({{"/devices/s/length_mm", 8}}, "accepted");
  expect({{"/devices/s/crimped_diameter_mm", 3}}, "as wide crimped");
  expect({{"/devices/b/crimped_diameter_mm", 3}}, "as wide crimped");
  expect({{"/devices/s/crimped_diameter_mm", 0.7}}, "thinner than the balloon");
  expect({{"/devices/s/nominal_diameter_mm", 0.5}, {"/devices/s/crimped_diameter_mm", 0.4}}, "another diameter");
  expect({{"/devices/s/nominal_diameter_mm", 4.4}}, "another diameter");
  expect({{"/devices/s/nominal_diameter_mm", 2.75}}, "accepted");
  expect({{"/devices/s/links", 30}}, "more links than crowns");
  expect({{"/devices/s/links", 8}}, "accepted");
  expect({{"/devices/s/strut_thickness_mm", 0.5}}, "no lumen");
  expect({{"/devices/b/chart/diameter_mm", {2.8, 3.0, 1e300}}}, "chart.diameter_mm");
  expect({{"/devices/b/chart/diameter_mm", {1.4, 3.0, 3.2}}}, "chart.diameter_mm");
  expect({{"/devices/b/chart/pressure_bar", {2, 8, 1e300}}}, "chart.pressure_bar");
}

TEST(Scene, RefusesAFirstStepLongerThanAny) {
  json d = good_scene();
  d["numerics"] = {{"initial_step_ms", 300}};
  EXPECT_NE(refusal(d).find("numerics.initial_step_ms"), std::string::npos) << refusal(d);
  d["numerics"]["maximal_step_ms"] = 300;
  EXPECT_EQ(refusal(d), "accepted");
}

TEST(Scene, TextbookIntegrationRefusesWhatOnlyTheAdaptiveOneHeeds) {
  json d = good_scene();
  d["numerics"] = {{"integration", "textbook"}, {"fixed_step_ms", 0.02}, {"damping_mpa_ms_per_mm", 2.5}};
  EXPECT_EQ(refusal(d), "accepted") << "a default may be written out";
  for (const auto& [key, value] : std::map<std::string, json>{{"residual_tolerance", 1e-3},
                                                              {"displacement_per_step_mm", 0.1},
                                                              {"initial_step_ms", 1},
                                                              {"maximal_step_ms", 10},
                                                              {"stalled_steps_per_stage", 50},
                                                              {"pcg_patch_vertices", 0},
                                                              {"damping_mpa_ms_per_mm", 1},
                                                              {"stiffness_damping_ms", 1},
                                                              {"region_margin_mm", 3}}) {
    d["numerics"] = {{"integration", "textbook"}, {key, value}};
    EXPECT_NE(refusal(d).find("numerics." + key), std::string::npos) << key << ": " << refusal(d);
    d["numerics"]["integration"] = "adaptive";
    EXPECT_EQ(refusal(d), "accepted") << key;
  }
}

TEST(Scene, RefusesAKeyGivenTwiceAndNamesIt) {
  const std::string good = good_scene().dump();
  const auto with = [&](const std::string& before, const std::string& extra) {
    std::string text = good;
    text.insert(text.find(before), extra);
    try {
      read_scene(SceneFile(text).path());
    } catch (const common::InputError& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_NE(with("\"map_pa\"", "\"map_pa\":9000,").find("scene.patient.map_pa"), std::string::npos);
  EXPECT_NE(with("\"schema\"", "\"schema\":1,").find("given twice"), std::string::npos);
  EXPECT_NE(with("\"chart\"", "\"chart\":{},").find("scene.devices.b.chart"), std::string::npos);
  EXPECT_EQ(with("\"schema\"", "\"numerics\":{},\"wall\":{},"), "accepted") << "keys of one name in several objects";
}

TEST(Scene, RefusesValuesDeepInOneAnother) {
  const SceneFile deep(R"({"schema": )" + std::string(300000, '[') + std::string(300000, ']') + "}");
  try {
    read_scene(deep.path());
    FAIL() << "read";
  } catch (const common::InputError& e) {
    EXPECT_NE(std::string(e.what()).find("too deep"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("scene.schema"), std::string::npos) << e.what();
  }
}

TEST(Scene, NamesTheKeyOfANumberThatIsTooLarge) {
  std::string text = good_scene().dump();
  const std::size_t at = text.find("12000");
  ASSERT_NE(at, std::string::npos);
  text.replace(at, 5, "1e999");
  try {
    read_scene(SceneFile(text).path());
    FAIL() << "accepted";
  } catch (const common::InputError& e) {
    const std::string message = e.what();
    EXPECT_NE(message.find("scene.patient.map_pa"), std::string::npos) << message;
    EXPECT_NE(message.find("out of its range"), std::string::npos) << message;
    EXPECT_EQ(message.find("damaged"), std::string::npos) << message;
  }
}

TEST(Scene, RefusesNamesThatAreNoFiles) {
  const auto named = [](const std::string& step, const std::string& device) {
    json d = good_scene();
    d["procedure"][0]["name"] = step;
    d["devices"][device] = d["devices"]["b"];
    return refusal(d);
  };
  EXPECT_NE(named("stent 1, LAD", "c"), "accepted");
  EXPECT_EQ(named("Stent 1_prox-3.5", "semi_2.50x12"), "accepted");
  for (const char* bad : {"../escape", "a/b", "a\\b", ".hidden", "", "line\nbreak", "\u00e9tape"}) {
    EXPECT_NE(named(bad, "c").find("procedure[0].name"), std::string::npos) << bad;
    EXPECT_NE(named("p", bad).find("cannot be a file's"), std::string::npos) << bad;
  }
  EXPECT_NE(named(std::string(101, 'x'), "c").find("cannot be a file's"), std::string::npos);
  json d = good_scene();
  d["procedure"].push_back(d["procedure"][0]);
  EXPECT_NE(refusal(d).find("two steps of one name"), std::string::npos) << refusal(d);
}

TEST(Scene, RefusesMissingKeysFilesAndText) {
  json d = good_scene();
  d.erase("patient");
  EXPECT_NE(refusal(d).find("patient"), std::string::npos);
  EXPECT_THROW(read_scene("no/such/scene.json"), common::InputError);
  const SceneFile file("{,}");
  EXPECT_THROW(read_scene(file.path()), common::InputError);
}

} // namespace
