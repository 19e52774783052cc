// Results that a clinician asks for: areas, expansion, recoil, foreshortening, straightening, malapposition.
#pragma once
#include "vci/geometry/crossings.hpp"
#include "vci/procedure/deployment.hpp"

namespace vci {

/// The document deployment.json of a run of `vci deploy`.
/// @param before axes of the branches before the procedure
nlohmann::json readouts(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& before,
                        const DeploymentResult& deployment);

/// Limits of a stent's result, beyond which a run gives a warning.
struct OutcomeLimits {
  /// Least expansion index. OCT found a median of 0.73 with quartiles of 0.63 and 0.81 (ILUMIEN II, Maehara 2015), so
  /// less than 0.6 is worse than in three of four patients. The European consensus asks for 0.8 (Raeber 2018).
  double least_expansion = 0.6;
  /// Largest gap (mm) between stent and wall. The European consensus on intracoronary imaging leaves acute
  /// malapposition below 0.4 mm uncorrected if it is shorter than 1 mm (Raeber, Eur Heart J 2018; 39: 3281-3300).
  double largest_malapposition = 0.4;
};

/// Warnings of stents that remain too small, and of a gap between stent and wall.
/// @param stents the list `stents` of deployment.json; a null expansion index (no healthy area known) gives no warning
/// @param malapposition_mm largest gap
std::vector<std::string> warnings_of_outcome(const nlohmann::json& stents, double malapposition_mm,
                                             const OutcomeLimits& limits = {});

/// Warning of a wall that crosses itself. Nothing in the model keeps the wall from this: at a carina, a wide balloon
/// may push the wall of one branch through that of the other.
std::string crossing_warning(const Crossings& found);

/// Lumen areas every 0.5 mm along a branch from s_start to s_end (mm), as a list of {s_mm, area_mm2}. An area is null
/// if its section has no closed outline.
nlohmann::json area_profile(const Vectors& points, const Triangles& triangles, const Path& path, double s_start,
                            double s_end);

/// The smallest area (mm^2) of an area_profile(); null if no section has an area.
nlohmann::json smallest_area(const nlohmann::json& profile);

/// The span of a branch that is reported: the scene's segment, else the span of the first stent, else that of the first
/// device.
Segment reported_segment(const Scene& scene);

} // namespace vci
