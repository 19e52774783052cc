#include "vci/procedure/placement.hpp"
#include "vci/geometry/closest_point.hpp"

#include <algorithm>
#include <cmath>

namespace vci {

namespace {

// Distances of a device's axis from a stent's axis, in stent radii. A device with a ring beyond `exit_offset` leaves
// the stent through its side. Its rings beyond `window_offset` then open a window in the stent.
constexpr double exit_offset = 0.6;
constexpr double window_offset = 0.3;
constexpr double axis_tolerance = 0.15; // mm by which the axes of nested devices may differ

/// The place nearest to p on the line through the centres of a device's rings.
struct AxisProjection {
  Vec3 point;
  double radius; ///< device's radius there, interpolated between its rings, mm
  bool past_end; ///< whether p is past the line's ends
};
AxisProjection project_onto_axis(const Vec3& p, const Vectors& centres, const std::vector<double>& radii) {
  AxisProjection best{centres.front(), radii.front(), true};
  double distance = 1e300;
  for (std::size_t k = 0; k + 1 < centres.size(); ++k) {
    const Vec3 along = centres[k + 1] - centres[k];
    const double t = (p - centres[k]).dot(along) / along.squaredNorm(), inside = std::clamp(t, 0.0, 1.0);
    const Vec3 q = centres[k] + inside * along;
    if ((p - q).squaredNorm() >= distance)
      continue;
    distance = (p - q).squaredNorm();
    const bool past = (k == 0 && t < 0) || (k + 2 == centres.size() && t > 1);
    best = {q, (1 - inside) * radii[k] + inside * radii[k + 1], past};
  }
  return best;
}

/// Flags the vertices round a window: those that are not in the window, but have a neighbour in it.
/// @param window whether each of the body's vertices lies in the window
std::vector<char> window_rim(const std::vector<char>& window, const Body& body) {
  std::vector<char> rim(window.size(), 0);
  for (const Triangle& t : body.triangles)
    if (std::any_of(t.begin(), t.end(), [&](int v) { return window[v - body.first]; }))
      for (int v : t)
        rim[v - body.first] = !window[v - body.first];
  return rim;
}

Vectors frame_origins(const DeviceLayout& layout) {
  Vectors points;
  for (const Frame& f : layout.frames)
    points.push_back(f.origin);
  return points;
}

} // namespace

ContactScope exclude_side_exit(const System& system, const Stent& stent, const DeviceLayout& device) {
  const Vectors axis = ring_centres(system, stent.body, stent.grid), device_axis = frame_origins(device);
  const std::vector<double> radii = ring_radii(system, stent.body, stent.grid);
  std::vector<double> offset; // distance of each device ring from the stent's axis, in stent radii; 0 past its ends
  for (const Vec3& o : device_axis) {
    const AxisProjection a = project_onto_axis(o, axis, radii);
    offset.push_back(a.past_end ? 0 : (o - a.point).norm() / a.radius);
  }
  ContactScope scope;
  if (*std::max_element(offset.begin(), offset.end()) < exit_offset)
    return scope;
  const std::vector<double> reach(device.frames.size(), device.inflated_radius);
  const Vectors inflated = place_grid(device.grid, device.frames, reach);
  for (const Vec3& p : inflated) {
    const AxisProjection a = project_onto_axis(p, axis, radii);
    scope.inner_excluded.push_back(!a.past_end &&
                                   (p - a.point).norm() > std::max(a.radius, device.inflated_radius) + axis_tolerance);
  }
  const Body& body = system.body(stent.body);
  scope.outer_excluded.assign(body.count, 0);
  for (int v = 0; v < body.count; ++v) {
    const Vec3& p = system.x[body.first + v];
    const AxisProjection a = project_onto_axis(p, axis, radii);
    for (std::size_t r = 0; r < device_axis.size(); ++r)
      if (offset[r] > window_offset && (p - device_axis[r]).norm() < device.inflated_radius + axis_tolerance &&
          (p - a.point).dot(device_axis[r] - a.point) > 0)
        scope.outer_excluded[v] = 1;
  }
  scope.outer_rim = window_rim(scope.outer_excluded, body);
  return scope;
}

std::vector<double> start_radii(const System& system, const DeviceLayout& device, double crimped_diameter,
                                const std::vector<ContactScope>& scopes) {
  constexpr double near = 6.0; // mm: triangles whose first corner is further from a ring's centre are not considered
  std::vector<double> radii;
  for (int r = 0; r < device.grid.rings(); ++r) {
    const Vec3& p = device.frames[r].origin;
    double nearest = near * near;
    for (int b = 0; b < system.bodies(); ++b) {
      const Body& body = system.body(b);
      const bool whole = b >= static_cast<int>(scopes.size()) || scopes[b].outer_excluded.empty();
      for (const Triangle& t : body.triangles) {
        if ((system.x[t[0]] - p).squaredNorm() > near * near)
          continue;
        if (!whole && std::any_of(t.begin(), t.end(), [&](int v) { return scopes[b].outer_excluded[v - body.first]; }))
          continue;
        nearest =
            std::min(nearest, closest_on_triangle(p, system.x[t[0]], system.x[t[1]], system.x[t[2]]).distance_squared);
      }
    }
    const double fits = 0.95 * std::sqrt(nearest) - start_clearance;
    radii.push_back(std::max(0.05, std::min(0.5 * crimped_diameter * device.grid.start_ratio[r], fits)));
  }
  return radii;
}

void set_side_by_side(DeviceLayout& one, DeviceLayout& other, double crimped_diameter) {
  const double wanted = crimped_diameter + 2 * start_clearance;
  const std::array<Vectors, 2> axes{frame_origins(one), frame_origins(other)};
  const std::array<std::vector<double>, 2> zero_radii{std::vector<double>(axes[0].size(), 0.0),
                                                      std::vector<double>(axes[1].size(), 0.0)};
  const Vec3 towards = axes[1].back() - axes[0].back();
  for (int k = 0; k < 2; ++k)
    for (Frame& f : (k == 0 ? one : other).frames) {
      const AxisProjection a = project_onto_axis(f.origin, axes[1 - k], zero_radii[1 - k]);
      const double distance = (f.origin - a.point).norm();
      if (distance >= wanted)
        continue;
      Vec3 across = towards - towards.dot(f.tangent) * f.tangent;
      if (across.norm() < 0.1 * wanted) // the devices' ends lie in one vessel, so any direction across it will do
        across = f.first;
      f.origin += (k == 0 ? -0.5 : 0.5) * (wanted - distance) * across.normalized();
    }
}

} // namespace vci
