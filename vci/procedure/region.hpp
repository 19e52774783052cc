// The part of the lumen that a procedure moves.
#pragma once
#include "vci/geometry/centreline.hpp"
#include "vci/geometry/lumen.hpp"
#include "vci/scene/scene.hpp"

namespace vci {

/// Flags the lumen vertices that may move: those of a device's branch up to the scene's region margin (mm) beyond its
/// ends, and those of other branches within this margin of the opened device.
std::vector<char> region_of_interest(const Lumen& lumen, const Scene& scene, const std::map<std::string, Path>& paths);

/// Flags the points (mm) beside a stretch of a branch, from arc length `from` to `to` (mm). No axis of another branch
/// may be nearer to them by more than 0.1 mm. A side branch's axis begins with a stretch of its parent's, so the wall
/// of this stretch belongs to both branches.
std::vector<char> points_beside(const Vectors& points, const std::map<std::string, Path>& paths,
                                const std::string& branch, double from, double to);

} // namespace vci
