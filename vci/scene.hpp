// scene.json: what to deploy where, checked before any work.
#pragma once
#include "vci/contact.hpp"
#include "vci/integrator.hpp"
#include "vci/spring_mapping.hpp"
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

namespace vci {

/// How a balloon is folded before it is inflated.
struct FoldingSpec {
  int wings = 3;
  double shaft_diameter = 0.5, membrane_thickness = 0.02; ///< mm
  bool clockwise = false; ///< sense of the wrap from valley to crest, seen against the vessel's direction
};

struct BalloonSpec {
  double nominal_diameter, length, shoulder, crimped_diameter; ///< mm
  double rated_burst_pressure_bar;
  std::vector<double> chart_pressure_bar, chart_diameter; ///< bar, mm
  std::optional<FoldingSpec> folding = std::nullopt;      ///< none: a small tube that unfolds softly
};

struct StentSpec {
  double nominal_diameter, length, crimped_diameter, maximal_diameter, strut_thickness; ///< mm
  int crowns, links;
  std::string balloon;
  double hoop_stiffness, yield_strain, axial_stiffness, bending_stiffness; ///< N/mm, -, N/mm, N mm^2
  double radial_strength_mpa,
      recoil_percent; ///< the maker's; the strength gives the hoop stiffness where none is stated
};

struct Placement {
  std::string device, branch;
  double centre_s, pressure_bar; ///< mm, bar
};

struct Step {
  std::string name, action;
  std::vector<Placement> devices;
};

struct PlaqueSpec {
  double youngs_modulus, yield_strain, hardening;
};

struct WallSpec {
  std::string model = "membrane"; ///< or mass-spring
  SpringMapping spring_mapping = SpringMapping::lame;
  double youngs_modulus = 0.8, poisson_ratio = 0.45, intima_thickness = 0.2, media_thickness = 0.4, stiffening = 3;
  double tissue_modulus = 0.08, tangential_stiffness = 0.02, density = 0.0011, hinge_yield = 0.1;
  std::array<PlaqueSpec, 4> plaque; ///< by plaque_type; 0 unused
};

struct Numerics {
  IntegratorSettings integrator;
  ContactSettings contact;
  double tie_stiffness = 60, region_margin = 6, device_edge = 0.45, contact_pressure_fraction = 0.5;
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

/// Reads and checks a scene. Throws common::InputError naming file, key, value and remedy.
Scene read_scene(const std::filesystem::path& file);
BalloonSpec read_balloon(const nlohmann::json& entry, const std::string& where);
StentSpec read_stent(const nlohmann::json& entry, const std::string& where);
/// Throws common::InputError where a stent cannot have been crimped on a balloon.
void check_mounted(const StentSpec& stent, const BalloonSpec& balloon, const std::string& where);

} // namespace vci
