#include "vci/scene/files/scene_file.hpp"
#include "common/error.hpp"
#include "vci/scene/files/checked_json.hpp"
#include "vci/scene/files/device_entries.hpp"
#include "vci/scene/files/reading.hpp"
#include "vci/scene/files/settings.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <set>

namespace vci {

using nlohmann::json;

namespace {

const std::map<std::string, Action> actions{{"predilatation", Action::predilatation},
                                            {"stent", Action::stent},
                                            {"postdilatation", Action::postdilatation},
                                            {"proximal_optimisation", Action::proximal_optimisation},
                                            {"side_branch_opening", Action::side_branch_opening},
                                            {"kissing", Action::kissing}};

Action read_action(CheckedObject& step) {
  const std::string action = step.text("action");
  if (!actions.contains(action))
    throw common::InputError(
        "an unknown action", step.path("action"), action,
        "use predilatation, stent, postdilatation, proximal_optimisation, side_branch_opening or kissing");
  return actions.at(action);
}

/// Refuses names of steps and devices that cannot be file names.
void check_name(const std::string& name, const std::string& where) {
  constexpr std::size_t longest = 100;
  const bool plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return (c < 128 && std::isalnum(c)) || c == ' ' || c == '.' || c == '_' || c == '-';
  });
  if (!plain || name.empty() || name.size() > longest || name.front() == '.')
    throw common::InputError("a name that cannot be a file's", where, json(name).dump().substr(0, 80),
                             "use letters, digits, space, point, underscore and hyphen, 1 to " +
                                 std::to_string(longest) + ", no point at first");
}

Step read_step(const json& entry, const std::string& where, const Scene& scene) {
  CheckedObject o(entry, where);
  Step step{o.text("name"), Action::predilatation, {}};
  check_name(step.name, o.path("name"));
  step.action = read_action(o);
  const json list = o.list("devices");
  for (std::size_t k = 0; k < list.size(); ++k) {
    CheckedObject d(list[k], where + ".devices[" + std::to_string(k) + "]");
    Placement p{d.text("device"), d.text("branch", "main"), d.number("centre_s_mm", -1e4, 1e4), 0};
    const bool stent = scene.stents.contains(p.device), balloon = scene.balloons.contains(p.device);
    if (!stent && !balloon)
      throw common::InputError("a device that the scene does not define", d.path("device"), p.device,
                               "add it under devices or correct the name");
    const BalloonSpec& b = scene.balloon(p.device);
    p.pressure_bar = d.number("pressure_bar", 0.1, 40);
    if (stent != (step.action == Action::stent))
      throw common::InputError(stent ? "a stent in a step that only inflates balloons" : "a balloon in a stent's step",
                               d.path("device"), p.device,
                               stent ? "name a balloon, or write action stent" : "name a stent, or another action");
    const double ceiling = 1.5 * b.rated_burst_pressure_bar;
    if (p.pressure_bar > ceiling)
      throw common::InputError("a pressure far beyond the balloon's rated burst pressure", d.path("pressure_bar"),
                               std::to_string(p.pressure_bar), "stay below " + std::to_string(ceiling) + " bar");
    if (p.pressure_bar > b.chart_pressure_bar.back())
      throw common::InputError("a pressure beyond the end of the balloon's chart", d.path("pressure_bar"),
                               std::to_string(p.pressure_bar),
                               "stay at or below its last pressure, " + std::to_string(b.chart_pressure_bar.back()) +
                                   " bar, or extend the chart");
    d.refuse_unknown_keys();
    step.devices.push_back(p);
  }
  if (step.devices.size() > 1 && step.action != Action::kissing)
    throw common::InputError("several devices in one step", o.path("devices"), std::to_string(step.devices.size()),
                             "only kissing inflates several balloons at once; use one step per device");
  const bool with_stent = std::any_of(step.devices.begin(), step.devices.end(),
                                      [&](const Placement& p) { return scene.stents.contains(p.device); });
  if (step.action == Action::kissing && (step.devices.size() != 2 || with_stent))
    throw common::InputError("kissing inflates two balloons side by side", o.path("devices"),
                             std::to_string(step.devices.size()) + (with_stent ? " devices, with a stent" : " devices"),
                             "name two balloons; place stents in steps of their own");
  o.refuse_unknown_keys();
  return step;
}

/// Parses a document and makes two checks. If a key were given twice in one object, the JSON library would silently use
/// the last. Values nested too deeply would crash the program, since they are copied and written by recursion.
json parse_json(std::istream& stream, const std::string& where) {
  struct OpenObject {
    std::set<std::string> keys;
    std::string last_key;
  };
  constexpr int maximal_depth = 32; // a device of a step is 5 deep
  std::vector<OpenObject> objects;  // objects that are not yet closed
  const auto current_path = [&] {
    std::string path = where;
    for (const OpenObject& o : objects)
      path += "." + o.last_key;
    return path;
  };
  try {
    return json::parse(stream, [&](int depth, json::parse_event_t event, const json& value) {
      if (depth > maximal_depth)
        throw common::InputError("values too deep in one another", current_path(), std::to_string(depth) + " levels",
                                 "no part of a scene is deeper than 5; docs/design.md describes the file");
      if (event == json::parse_event_t::object_start)
        objects.emplace_back();
      else if (event == json::parse_event_t::object_end)
        objects.pop_back();
      else if (event == json::parse_event_t::key) {
        objects.back().last_key = value.get<std::string>();
        if (!objects.back().keys.insert(objects.back().last_key).second)
          throw common::InputError("a key is given twice", current_path(), objects.back().last_key,
                                   "leave one of the two");
      }
      return true;
    });
  } catch (const json::out_of_range& e) { // a number that no double holds
    throw common::InputError("a number is out of its range", current_path(), e.what(), "give a number below 1e308");
  }
}

json read_document(const std::filesystem::path& file, const std::string& where) {
  std::ifstream stream(file);
  if (!stream)
    throw common::InputError("the scene cannot be opened", file.string(), "no readable file", "check the path");
  try {
    return parse_json(stream, where);
  } catch (const json::parse_error& e) {
    throw common::InputError("the scene is not JSON", file.string(), e.what(), "correct the text at that byte");
  }
}

Segment read_segment(const json& entry, const std::string& where) {
  CheckedObject o(entry, where);
  const Segment segment{o.text("branch", "main"), o.number("s_start_mm", 0, 1e4), o.number("s_end_mm", 0, 1e4)};
  o.refuse_unknown_keys();
  if (segment.s_end <= segment.s_start)
    throw common::InputError("the segment ends before it starts", where, entry.dump(), "give s_start_mm < s_end_mm");
  return segment;
}

void read_settings(CheckedObject& o, Scene& scene) {
  CheckedObject wall(o.child("wall", false), o.path("wall")), numerics(o.child("numerics", false), o.path("numerics"));
  scene.wall = read_wall(wall);
  scene.numerics = read_numerics(numerics);
  scene.settings = {{"wall", wall.values_read}, {"numerics", numerics.values_read}, {"map_pa", scene.map_pa}};
}

void read_devices(CheckedObject& o, Scene& scene) {
  const json devices = o.child("devices", true);
  CheckedObject(devices, o.path("devices"));
  for (const auto& [name, entry] : devices.items()) {
    const std::string at = o.path("devices") + "." + name, kind = CheckedObject(entry, at).text("kind");
    check_name(name, at);
    if (kind == "balloon")
      scene.balloons[name] = read_balloon(entry, at);
    else if (kind == "stent")
      scene.stents[name] = read_stent(entry, at);
    else
      throw common::InputError("an unknown kind of device", at + ".kind", kind, "use balloon or stent");
  }
  for (const auto& [name, stent] : scene.stents) {
    const std::string at = o.path("devices") + "." + name;
    if (!scene.balloons.contains(stent.balloon))
      throw common::InputError("a stent without its delivery balloon", at + ".balloon", stent.balloon,
                               "add that balloon under devices");
    check_stent_on_balloon(stent, scene.balloons.at(stent.balloon), at);
  }
}

void read_procedure(CheckedObject& o, Scene& scene) {
  const json steps = o.list("procedure");
  std::set<std::string> names;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const std::string at = o.path("procedure") + "[" + std::to_string(k) + "]";
    scene.procedure.push_back(read_step(steps[k], at, scene));
    if (!names.insert(scene.procedure.back().name).second)
      throw common::InputError("two steps of one name", at + ".name", scene.procedure.back().name,
                               "name each step otherwise: files are named by it");
  }
}

/// Reads patient, settings, devices and steps.
void read_intervention(CheckedObject& o, Scene& scene) {
  CheckedObject patient(o.child("patient", true), o.path("patient"));
  scene.map_pa = patient.number("map_pa", 1000, 40000);
  patient.refuse_unknown_keys();
  read_settings(o, scene);
  read_devices(o, scene);
  read_procedure(o, scene);
}

Scene load_scene(const std::filesystem::path& file) {
  const std::string where = file.string() + ": scene";
  CheckedObject o(read_document(file, where), where);
  const std::string schema = o.text("schema");
  if (schema != "vci-scene-1")
    throw common::InputError("not a scene of this version", o.path("schema"), schema, "write \"vci-scene-1\"");
  Scene scene;
  scene.file = file;
  scene.case_name = o.text("case", "");
  scene.lumen = file.parent_path() / o.text("lumen");
  scene.centreline = file.parent_path() / o.text("centreline");
  if (o.has("coarse_lumen"))
    scene.coarse_lumen = file.parent_path() / o.text("coarse_lumen");
  if (o.has("segment"))
    scene.segment = read_segment(o.child("segment", true), o.path("segment"));
  if (o.has("reference")) // a proposed plan writes it for the report's page; not used here
    o.child("reference", true);
  read_intervention(o, scene);
  o.refuse_unknown_keys();
  return scene;
}

} // namespace

Scene scene_from(const json& entries, const std::string& name) {
  return guarded_read(name, [&] {
    Scene scene;
    scene.file = scene.lumen = scene.centreline = name;
    CheckedObject o(entries, name + ": scene");
    read_intervention(o, scene);
    o.refuse_unknown_keys();
    return scene;
  });
}

Scene read_scene(const std::filesystem::path& file) {
  return guarded_read(file, [&] { return load_scene(file); });
}

} // namespace vci
