#include "vci/contact/apposition.hpp"
#include "vci/contact/contact.hpp"
#include "vci/contact/surface_projection.hpp"
#include "vci/geometry/broad_phase.hpp"
#include "vci/geometry/surface.hpp"

#include <algorithm>
#include <optional>

namespace vci {

namespace {

// mm: a stent further from a wall vertex lies against another part of the wall. A 2.25 mm stent that touches one side
// of a left main of 6 mm is 3.75 mm off the other side.
constexpr double apposition_reach = 5.0;
// mm: a vertex may project along the normals onto a triangle that is farther than the nearest one by up to this length
constexpr double projection_slack = 0.1;
constexpr double no_gap = 1e300;

/// Gap (mm) from a wall vertex to the smooth surface of a stent, measured as in contact; 0 if they touch or overlap.
/// Returns nothing if the vertex projects onto the stent's open end, or if the outward normals of wall and stent point
/// opposite ways.
/// @param unit_normals unit normals of all vertices
/// @param candidates numbers of the stent's triangles near the vertex
std::optional<double> gap_to_stent(const System& system, const Body& stent, const Vectors& unit_normals, int vertex,
                                   const std::vector<int>& candidates) {
  double distance = 0;
  const Vec3& p = system.x[vertex];
  const SurfaceProjection projection = project_onto(p, candidates, system, unit_normals, stent, distance);
  if (projection.triangle < 0)
    return std::nullopt;
  const Triangle& t = stent.triangles[projection.triangle];
  double inside = 0;
  Vec3 q = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    inside += stent.boundary[t[k] - stent.first] ? 0 : projection.weights[k];
    q += projection.weights[k] * system.x[t[k]];
  }
  const Vec3 n = interpolated_normal(t, projection.weights, unit_normals);
  if (inside <= 1e-9 || n.dot(unit_normals[vertex]) <= 0)
    return std::nullopt;
  return std::max(0.0, n.dot(p - q) - sagitta(t, projection.weights, system.x, unit_normals));
}

} // namespace

std::vector<double> malapposition(const System& system, const std::vector<StentAtWall>& stents) {
  const Body& wall = system.body(0);
  Vectors unit_normals = area_vectors(system);
  for (Vec3& n : unit_normals)
    n.normalize();
  std::vector<double> gaps(wall.count, no_gap);
  std::vector<NearTriangle> found;
  std::vector<int> candidates;
  for (const StentAtWall& stent : stents) {
    const Body& body = system.body(stent.body);
    const BroadPhase boxes(body.triangles, system.x);
    for (int i = 0; i < wall.count; ++i) {
      if (!stent.wall.empty() && !stent.wall[i])
        continue;
      boxes.find_near(system.x[i], body.triangles, system.x, apposition_reach, projection_slack, -1, found);
      candidates.clear();
      for (const NearTriangle& f : found)
        candidates.push_back(f.triangle);
      if (candidates.empty())
        continue;
      if (const std::optional<double> gap = gap_to_stent(system, body, unit_normals, i, candidates))
        gaps[i] = std::min(gaps[i], *gap);
    }
  }
  std::replace(gaps.begin(), gaps.end(), no_gap, 0.0);
  return gaps;
}

} // namespace vci
