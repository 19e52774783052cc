// Results that a clinician asks for: areas, expansion, recoil, foreshortening, straightening, apposition.
#pragma once
#include "vci/procedure/deployment.hpp"

namespace vci {

/// deployment.json of a run of `vci deploy`.
nlohmann::json readouts(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& before,
                        const DeploymentResult& deployment);

/// Limits of a stent's result. Beyond them a run warns.
struct OutcomeLimits {
  /// Least expansion index. OCT found a median of 0.73 with quartiles of 0.63 and 0.81 (ILUMIEN II, Maehara 2015), so
  /// less than 0.6 is worse than in three of four patients. The European consensus asks for 0.8 (Raeber 2018).
  double least_expansion = 0.6;
  /// Largest gap (mm) between stent and wall. The European consensus on intracoronary imaging corrects acute
  /// malapposition from 0.4 mm on (Raeber, Eur Heart J 2018; 39: 3281-3300).
  double largest_malapposition = 0.4;
};

/// Warnings of stents that stay too small, and of a gap between stent and wall.
/// @param stents rows of `stents` of deployment.json; a null expansion index (no healthy area known) gives no warning
std::vector<std::string> warnings_of_outcome(const nlohmann::json& stents, double malapposition_mm,
                                             const OutcomeLimits& limits = {});

/// Lumen areas every 0.5 mm along a span of a branch: [{s_mm, area_mm2}]; null if the section has no closed outline.
nlohmann::json area_profile(const Vectors& points, const Triangles& triangles, const Path& path, double s_start,
                            double s_end);

/// The smallest area of a profile; null if no section has an area.
nlohmann::json smallest_area(const nlohmann::json& profile);

/// Span of a branch for reports: the scene's segment, else the stents' span, else the first device's.
Segment reported_segment(const Scene& scene);

} // namespace vci
