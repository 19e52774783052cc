// The figures that a clinician asks for: areas, expansion, recoil, foreshortening, straightening, apposition.
#pragma once
#include "vci/procedure/deployment.hpp"

namespace vci {

/// deployment.json of a run of `vci deploy`.
nlohmann::json readouts(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& before,
                        const DeploymentResult& deployment);

/// Lumen areas every 0.5 mm along a span of a branch: [{s_mm, area_mm2}]; null where the section has no closed outline.
nlohmann::json area_profile(const Vectors& points, const Triangles& triangles, const Path& path, double s_start,
                            double s_end);

/// The smallest area of a profile; null where no section has one.
nlohmann::json smallest_area(const nlohmann::json& profile);

/// Span of a branch that reports talk about: the scene's segment, else the stents', else the first device's.
Segment reported_segment(const Scene& scene);

} // namespace vci
