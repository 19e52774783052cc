// A scene: lumen, wall, devices, steps and numerical settings.
#pragma once
#include "vci/devices/balloon/balloon_spec.hpp"
#include "vci/devices/stent/stent_spec.hpp"
#include "vci/scene/numerics.hpp"
#include "vci/wall/wall_spec.hpp"
#include <algorithm>
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

enum class Action { predilatation, stent, postdilatation, proximal_optimisation, side_branch_opening, kissing };

struct Step {
  std::string name;
  Action action;
  std::vector<Placement> devices;
};

struct Segment {
  std::string branch;
  double s_start, s_end;
};

struct Scene {
  std::filesystem::path file, lumen, centreline; ///< the scene's own path, and the files that it names
  std::filesystem::path coarse_lumen; ///< same lumen with longer edges, deployed to carry `lumen`; empty: none
  std::string case_name;
  double map_pa = 12400; ///< mean blood pressure, Pa
  std::optional<Segment> segment;
  WallSpec wall;
  std::map<std::string, BalloonSpec> balloons;
  std::map<std::string, StentSpec> stents;
  std::vector<Step> procedure;
  Numerics numerics;
  nlohmann::json settings; ///< wall and numerics as used, defaults filled in

  /// The stent of that name; null if the device is a balloon.
  const StentSpec* stent(const std::string& device) const {
    const auto found = stents.find(device);
    return found == stents.end() ? nullptr : &found->second;
  }
  /// The balloon that is inflated: the device itself, or a stent's delivery balloon.
  const BalloonSpec& balloon(const std::string& device) const {
    const StentSpec* delivered = stent(device);
    return balloons.at(delivered ? delivered->balloon : device);
  }
  /// Length (mm) of a stent, or of a balloon without its shoulders.
  double length(const std::string& device) const {
    const StentSpec* delivered = stent(device);
    return delivered ? delivered->length : balloons.at(device).length;
  }
  /// Length (mm) of the stretch of vessel that is opened: that of the stent or of the balloon, whichever is longer.
  double opened_length(const std::string& device) const {
    const StentSpec* delivered = stent(device);
    return std::max(delivered ? delivered->length : 0.0, balloon(device).length);
  }
};

} // namespace vci
