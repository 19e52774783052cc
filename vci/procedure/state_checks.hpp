// Checks of the state: devices must lie inside the lumen after a stage, stents must be supported after a procedure.
#pragma once
#include "vci/procedure/stent_history.hpp"
#include "vci/solver/integrator.hpp"

namespace vci {

/// The device vertex that lies furthest outside the wall.
struct OutsideVertex {
  double distance = 0; ///< mm outside the smooth surface through the wall's vertices; 0: no vertex is outside
  int vertex = -1;
};

/// Finds the device vertex furthest outside the wall (body 0). Three kinds of vertices count as inside. Some are more
/// than 2 mm from the wall: a device that far outside would also have vertices nearer to the wall. The others lie
/// beside the wall's open ends, or in the mouth of a side branch.
/// @param trees search trees of the bodies
/// @param points, triangles of the whole closed lumen in its current state
OutsideVertex furthest_outside(const System& system, SurfaceTrees& trees, const Vectors& points,
                               const Triangles& triangles);

/// Throws common::ComputationError if a device vertex is more than 0.1 mm outside the wall.
/// @param where step and stage, for the message
void check_devices_inside(const System& system, SurfaceTrees& trees, const Vectors& points, const Triangles& triangles,
                          const std::string& where);

/// For each stent, whether the wall (body 0) supports it by contact or tie, directly or through other stents.
std::vector<char> stents_supported(const System& system, const std::vector<ContactPoint>& contacts,
                                   const std::vector<Tie>& ties, const std::vector<StentHistory>& stents);

/// Throws common::ComputationError if the wall does not support one of the stents.
/// @param points, triangles of the lumen in its current state
/// @param paths axes of the lumen's branches
void check_stents_supported(const System& system, Interactions& interactions, const std::vector<StentHistory>& stents,
                            const Vectors& points, const Triangles& triangles,
                            const std::map<std::string, Path>& paths);

} // namespace vci
