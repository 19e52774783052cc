#include "vci/procedure/state_checks.hpp"
#include "common/error.hpp"
#include "vci/contact/surface_projection.hpp"
#include "vci/geometry/sections.hpp"
#include "vci/geometry/surface.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

namespace vci {

namespace {

constexpr double wall_reach = 2.0; // mm: radius round a device's vertex in which the wall is searched
// mm: a vertex may project along the normals onto a triangle that is farther than the nearest one by up to this length
constexpr double projection_slack = 0.1;
constexpr double tolerated_distance = 0.1; // mm that a device may lie outside the wall; balanced stages have far less
constexpr double open_edge_weight = 1e-9;  // a projection with less weight at inner corners lies on an open edge

int body_of_vertex(const System& system, int vertex) {
  int body = 0;
  while (vertex >= system.body(body).first + system.body(body).count)
    ++body;
  return body;
}

/// Distance (mm) of a point outside the wall's smooth surface; negative inside, at open ends, and if no wall is near.
double distance_outside(const Vec3& p, const System& system, const Vectors& unit_normals,
                        const std::vector<int>& candidates) {
  const Body& wall = system.body(0);
  double closest = 0;
  const SurfaceProjection projection = project_onto(p, candidates, system, unit_normals, wall, closest);
  if (projection.triangle < 0)
    return -1;
  const Triangle& t = wall.triangles[projection.triangle];
  double inner = 0;
  Vec3 q = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    inner += wall.boundary[t[k] - wall.first] ? 0 : projection.weights[k];
    q += projection.weights[k] * system.x[t[k]];
  }
  if (inner <= open_edge_weight)
    return -1;
  return interpolated_normal(t, projection.weights, unit_normals).dot(p - q) -
         sagitta(t, projection.weights, system.x, unit_normals);
}

} // namespace

OutsideVertex furthest_outside(const System& system, SurfaceTrees& trees, const Vectors& points,
                               const Triangles& triangles) {
  const Body& wall = system.body(0);
  const Normals normals(area_vectors(system));
  const BroadPhase& boxes = trees.at(system, 0);
  OutsideVertex furthest;
  std::vector<NearTriangle> found;
  std::vector<int> candidates;
  for (int v = wall.first + wall.count; v < system.vertices(); ++v) {
    boxes.find_near(system.x[v], wall.triangles, system.x, wall_reach, projection_slack, -1, found);
    candidates.clear();
    for (const NearTriangle& f : found)
      candidates.push_back(f.triangle);
    if (candidates.empty())
      continue;
    const double distance = distance_outside(system.x[v], system, normals.unit, candidates);
    // At the mouth of a side branch the wall has an opening, whose sharp rim may fold. There the nearest triangle does
    // not tell inside from outside; the winding number of the whole lumen does.
    if (distance > furthest.distance &&
        (distance <= tolerated_distance || winding_number(system.x[v], triangles, points) < 0.5))
      furthest = {distance, v};
  }
  return furthest;
}

void check_devices_inside(const System& system, SurfaceTrees& trees, const Vectors& points, const Triangles& triangles,
                          const std::string& where) {
  const OutsideVertex furthest = furthest_outside(system, trees, points, triangles);
  if (furthest.distance <= tolerated_distance)
    return;
  const Vec3& at = system.x[furthest.vertex];
  std::ostringstream value;
  value << "a vertex of the " << system.body(body_of_vertex(system, furthest.vertex)).name << " at (" << at[0] << ", "
        << at[1] << ", " << at[2] << "), " << furthest.distance << " mm outside; at most " << tolerated_distance;
  throw common::ComputationError("a device lies outside the lumen", where, value.str(),
                                 "refine the lumen or the devices, or predilate first; no lumen is written");
}

std::vector<char> stents_supported(const System& system, const std::vector<ContactPoint>& contacts,
                                   const std::vector<Tie>& ties, const std::vector<StentHistory>& stents) {
  std::vector<int> group(system.bodies());
  std::iota(group.begin(), group.end(), 0);
  const auto join = [&](const StencilStiffness& stencil) {
    int first = -1;
    for (int k = 0; k < 4; ++k) {
      if (stencil.vertex[k] < 0 || stencil.weight[k] == 0)
        continue;
      const int body = group[body_of_vertex(system, stencil.vertex[k])];
      if (first >= 0)
        std::replace(group.begin(), group.end(), std::max(first, body), std::min(first, body));
      first = first < 0 ? body : std::min(first, body);
    }
  };
  for (const ContactPoint& p : contacts)
    if (p.force > 0)
      join(p.stencil);
  for (const Tie& tie : ties)
    join(tie.stencil);
  std::vector<char> result;
  for (const StentHistory& h : stents)
    result.push_back(group[h.stent.body] == group[0]);
  return result;
}

void check_stents_supported(const System& system, Interactions& interactions, const std::vector<StentHistory>& stents,
                            const Vectors& points, const Triangles& triangles,
                            const std::map<std::string, Path>& paths) {
  if (stents.empty())
    return;
  std::vector<ContactPoint> contacts;
  interactions.detect(system, area_vectors(system), contacts);
  const std::vector<char> held = stents_supported(system, contacts, interactions.ties, stents);
  for (std::size_t k = 0; k < stents.size(); ++k) {
    if (held[k])
      continue;
    const StentHistory& h = stents[k];
    const Path& path = paths.at(h.branch);
    const double lumen = section_area(points, triangles, section_normals(points, triangles), path.at(h.centre_s),
                                      path.tangent(h.centre_s));
    std::ostringstream value;
    value << "the stent's diameter is " << h.final_diameter << " mm";
    if (lumen > 0)
      value << ", the lumen's at its middle " << 2 * std::sqrt(lumen / pi) << " mm";
    throw common::ComputationError("a stent touches nothing once all balloons are out",
                                   h.device + " at " + h.branch + ", stent " + std::to_string(k + 1), value.str(),
                                   "choose a larger stent, raise its pressure_bar or dilate it with a larger balloon: "
                                   "it is smaller than the lumen");
  }
}

} // namespace vci
