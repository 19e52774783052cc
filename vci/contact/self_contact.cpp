#include "vci/contact/self_contact.hpp"
#include "vci/contact/surface_projection.hpp"
#include "vci/geometry/closest_point.hpp"
#include "vci/geometry/surface.hpp"

#include <algorithm>
#include <cmath>

namespace vci {

namespace {

constexpr double layer_reach = 0.15;   // mm: a layer further from a vertex is ignored
constexpr double facing_cosine = -0.2; // layers face each other if the cosine between their normals is below this
constexpr double release_cosine = 0.5; // above this cosine, a vertex that has passed through a layer is released
// Gap at which contact begins, over the thickness of a layer. With 1 the layers of a wrapped balloon would press on
// each other at rest: they lie one thickness apart, less the sagitta of their straight edges.
constexpr double contact_gap_share = 0.9;
constexpr int maximal_walk = 20;   // largest number of triangles that follow_layer() crosses in one call
constexpr double ramp_share = 0.4; // overlap over which the stiffness rises, as a share of the thickness
constexpr std::array<double, 2> side_signs{1.0, -1.0}; // sign of the gap on the outer and on the inner side of a vertex

/// Pressure (MPa) and its stiffness (MPa/mm) at a gap (mm). The pressure is quadratic over the ramp, then linear.
struct LayerLaw {
  double pressure, stiffness;
};
LayerLaw layer_law(double gap, double thickness, double kappa) {
  const double a = contact_gap_share * thickness - gap, w = ramp_share * thickness;
  if (a <= 0)
    return {0, 0};
  if (a < w)
    return {kappa * a * a / (2 * w), kappa * a / w};
  return {kappa * (a - 0.5 * w), kappa};
}

Vec3 point_on_triangle(const Triangle& t, const Vec3& weights, const Vectors& x) {
  return weights[0] * x[t[0]] + weights[1] * x[t[1]] + weights[2] * x[t[2]];
}

std::vector<std::vector<int>> triangles_sharing_vertex(const Triangles& triangles, int count) {
  std::vector<std::vector<int>> of_vertex(count), adjacent(triangles.size());
  for (std::size_t k = 0; k < triangles.size(); ++k)
    for (int v : triangles[k])
      of_vertex[v].push_back(static_cast<int>(k));
  for (std::size_t k = 0; k < triangles.size(); ++k) {
    for (int v : triangles[k])
      adjacent[k].insert(adjacent[k].end(), of_vertex[v].begin(), of_vertex[v].end());
    std::sort(adjacent[k].begin(), adjacent[k].end());
    adjacent[k].erase(std::unique(adjacent[k].begin(), adjacent[k].end()), adjacent[k].end());
    std::erase(adjacent[k], static_cast<int>(k));
  }
  return adjacent;
}

} // namespace

SelfContact::SelfContact(const System& system, int body, double stiffness, std::vector<double> thickness)
    : body_(body), stiffness_(0.5 * stiffness), thickness_(std::move(thickness)) {
  const Body& b = system.body(body);
  Triangles own_indices = b.triangles;
  for (Triangle& t : own_indices)
    for (int& v : t)
      v -= b.first;
  neighbours_ = vertex_neighbours(own_indices, b.count);
  for (int v = 0; v < b.count; ++v)
    neighbours_[v].insert(std::lower_bound(neighbours_[v].begin(), neighbours_[v].end(), v), v);
  adjacent_triangles_ = triangles_sharing_vertex(own_indices, b.count);
  for (auto& side : layers_)
    side.resize(b.count);
}

int SelfContact::count_facing() const {
  int count = 0;
  for (std::size_t k = 0; k < neighbours_.size(); ++k)
    count += layers_[0][k].triangle >= 0 || layers_[1][k].triangle >= 0;
  return count;
}

bool SelfContact::in_own_layer(int vertex, const Triangle& t, int first) const {
  const std::vector<int>& own_neighbours = neighbours_[vertex];
  return std::any_of(t.begin(), t.end(), [&](int v) {
    return std::binary_search(own_neighbours.begin(), own_neighbours.end(), v - first);
  });
}

/// Updates the point of the faced layer that is closest to the vertex. The search begins at the stored triangle and
/// goes on to neighbouring triangles as long as they are closer.
void SelfContact::follow_layer(const System& system, int vertex, FacedLayer& layer) const {
  const Body& body = system.body(body_);
  const Vec3& p = system.x[body.first + vertex];
  const auto closest = [&](int k) {
    const Triangle& t = body.triangles[k];
    return closest_on_triangle(p, system.x[t[0]], system.x[t[1]], system.x[t[2]]);
  };
  ClosestPoint best = closest(layer.triangle);
  for (int walked = 0; walked < maximal_walk && best.weights.minCoeff() < 1e-9; ++walked) {
    const int here = layer.triangle;
    for (int k : adjacent_triangles_[here]) {
      if (in_own_layer(vertex, body.triangles[k], body.first))
        continue;
      const ClosestPoint c = closest(k);
      if (c.distance_squared < best.distance_squared - 1e-16) {
        best = c;
        layer.triangle = k;
      }
    }
    if (layer.triangle == here)
      break;
  }
  layer.weights = best.weights;
  layer.distance = std::sqrt(best.distance_squared);
}

/// Measures the gap between a vertex and the layer that it faces. Returns false if the layer is out of reach or has
/// turned away.
bool SelfContact::still_faces(const System& system, int vertex, double side, FacedLayer& layer) const {
  follow_layer(system, vertex, layer);
  const Body& body = system.body(body_);
  const Triangle& t = body.triangles[layer.triangle];
  const Vec3 n = interpolated_normal(t, layer.weights, unit_normals_);
  layer.gap = side * n.dot(system.x[body.first + vertex] - point_on_triangle(t, layer.weights, system.x));
  const double cosine = n.dot(unit_normals_[body.first + vertex]);
  return layer.distance < layer_reach && cosine < (layer.gap > 0 ? facing_cosine : release_cosine);
}

/// Finds the nearest layer that faces the vertex, on each side of it. A layer found earlier is replaced only by a
/// nearer one, and not at all once the vertex has passed through it.
void SelfContact::search_layers(const System& system, int vertex, std::vector<NearTriangle>& found) {
  const Body& body = system.body(body_);
  const Vec3 &p = system.x[body.first + vertex], &normal = unit_normals_[body.first + vertex];
  boxes_->find_near(p, body.triangles, system.x, layer_reach, layer_reach, -1, found);
  for (const NearTriangle& f : found) {
    const Triangle& t = body.triangles[f.triangle];
    const bool has_contact = std::all_of(t.begin(), t.end(), [&](int v) { return thickness_[v - body.first] > 0; });
    if (!has_contact || in_own_layer(vertex, t, body.first))
      continue;
    const Vec3 n = interpolated_normal(t, f.weights, unit_normals_), d = p - point_on_triangle(t, f.weights, system.x);
    for (std::size_t k = 0; k < side_signs.size(); ++k) {
      FacedLayer& layer = layers_[k][vertex];
      const double gap = side_signs[k] * n.dot(d);
      const bool faces = gap > 0 && side_signs[k] * normal.dot(d) < 0 && n.dot(normal) < facing_cosine;
      if (faces && (layer.triangle < 0 || (layer.gap > 0 && f.distance < layer.distance)))
        layer = {f.triangle, Vec3::Zero(), f.weights, f.distance, gap};
    }
  }
}

/// Whether a layer that was out of reach in the last search may by now be near enough to touch. Adds the motion since
/// the last call to `travel_`.
bool SelfContact::search_due(const System& system) {
  const Body& body = system.body(body_);
  double moved = 0;
  if (last_positions_.size() == static_cast<std::size_t>(body.count))
    for (int v = 0; v < body.count; ++v)
      moved = std::max(moved, (system.x[body.first + v] - last_positions_[v]).squaredNorm());
  const double largest_distance = contact_gap_share * *std::max_element(thickness_.begin(), thickness_.end());
  last_positions_.assign(system.x.begin() + body.first, system.x.begin() + body.first + body.count);
  travel_ += std::sqrt(moved);
  return !boxes_ || 2 * travel_ > layer_reach - largest_distance;
}

void SelfContact::add_contact_point(const System& system, int vertex, double area, double side, FacedLayer& layer,
                                    std::vector<ContactPoint>& points) const {
  const LayerLaw law = layer_law(layer.gap, thickness_[vertex], stiffness_);
  if (law.pressure <= 0)
    return;
  const Body& body = system.body(body_);
  const Triangle& t = body.triangles[layer.triangle];
  const Vec3 &w = layer.weights, n = interpolated_normal(t, w, unit_normals_);
  points.push_back({{{body.first + vertex, t[0], t[1], t[2]},
                     {side, -side * w[0], -side * w[1], -side * w[2]},
                     n,
                     area * law.stiffness,
                     0.0},
                    area,
                    layer.gap,
                    area * law.pressure,
                    Vec3::Zero(),
                    &layer.slip});
}

void SelfContact::detect(const System& system, const Vectors& normals, std::vector<ContactPoint>& points) {
  const Body& body = system.body(body_);
  unit_normals_.resize(system.x.size());
  for (int v = body.first; v < body.first + body.count; ++v)
    unit_normals_[v] = normals[v].normalized();
  for (std::size_t k = 0; k < side_signs.size(); ++k)
    for (int v = 0; v < body.count; ++v)
      if (layers_[k][v].triangle >= 0 && !still_faces(system, v, side_signs[k], layers_[k][v]))
        layers_[k][v] = {};
  if (search_due(system)) {
    if (boxes_)
      boxes_->update(body.triangles, system.x);
    else
      boxes_ = std::make_unique<BroadPhase>(body.triangles, system.x);
    travel_ = 0;
    std::vector<NearTriangle> found;
    for (int v = 0; v < body.count; ++v)
      if (thickness_[v] > 0)
        search_layers(system, v, found);
  }
  for (std::size_t k = 0; k < side_signs.size(); ++k)
    for (int v = 0; v < body.count; ++v)
      if (layers_[k][v].triangle >= 0)
        add_contact_point(system, v, normals[body.first + v].norm(), side_signs[k], layers_[k][v], points);
}

} // namespace vci
