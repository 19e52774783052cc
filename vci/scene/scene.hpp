// What to deploy where, in which wall, by which settings.
#pragma once
#include "vci/devices/balloon/balloon_spec.hpp"
#include "vci/devices/stent/stent_spec.hpp"
#include "vci/scene/numerics.hpp"
#include "vci/wall/wall_spec.hpp"
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace vci {

struct Placement {
  std::string device, branch;
  double centre_s, pressure_bar; ///< mm, bar
};

struct Step {
  std::string name, action;
  std::vector<Placement> devices;
};

struct Segment {
  std::string branch;
  double s_start, s_end;
};

struct Scene {
  std::filesystem::path file, lumen, centreline; ///< of the scene itself, and of what it names
  std::string case_name;
  double map_pa;
  std::optional<Segment> segment;
  WallSpec wall;
  std::map<std::string, BalloonSpec> balloons;
  std::map<std::string, StentSpec> stents;
  std::vector<Step> procedure;
  Numerics numerics;
  nlohmann::json settings; ///< wall and numerics as used, defaults filled in
};

} // namespace vci
