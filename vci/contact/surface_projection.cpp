#include "vci/contact/surface_projection.hpp"
#include "vci/geometry/closest_point.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace vci {

Vec3 interpolated_normal(const Triangle& t, const Vec3& weights, const Vectors& unit_normals) {
  Vec3 n = Vec3::Zero();
  for (int k = 0; k < 3; ++k)
    n += weights[k] * unit_normals[t[k]];
  return n.normalized();
}

namespace {

/// Finds the point of a triangle from which p lies along the interpolated normal, by Newton's method. Unlike the
/// closest point, this point moves continuously across edges on both sides of a folded surface. Returns false if there
/// is no such point, if it lies far outside the triangle, or if the interpolated normal leans too far from the
/// triangle's own.
/// @param weights barycentric: first guess, then the result, which may lie outside the triangle
bool project_along_normals(const Vec3& p, const Triangle& t, const System& system, const Vectors& unit_normals,
                           Vec3& weights) {
  constexpr double weight_tolerance = 1e-5;
  constexpr int most_projection_iterations = 8;
  const Vec3 &a = system.x[t[0]], ab = system.x[t[1]] - a, ac = system.x[t[2]] - a;
  const Vec3 face = ab.cross(ac), pa = p - a;
  const double square = face.squaredNorm(), least_slope = 0.2 * std::sqrt(square), height = pa.dot(face);
  const Vec3 to_v = ac.cross(face) / square, to_w = face.cross(ab) / square; // weights of a point: products with these
  const Vec3 normal_b = unit_normals[t[1]] - unit_normals[t[0]], normal_c = unit_normals[t[2]] - unit_normals[t[0]];
  for (int iteration = 0; iteration < most_projection_iterations; ++iteration) {
    // q(v, w) is where the line from p along the normal n(v, w) meets the triangle's plane. At the projection it has
    // the weights v and w itself.
    const Vec3 n = unit_normals[t[0]] + weights[1] * normal_b + weights[2] * normal_c;
    const double slope = n.dot(face);
    if (slope <= least_slope * n.norm())
      return false;
    const Vec3 q = pa - height / slope * n;
    const auto derivative = [&](const Vec3& dn) { return Vec3(height / slope * (dn.dot(face) / slope * n - dn)); };
    const Vec3 by_v = derivative(normal_b), by_w = derivative(normal_c);
    Eigen::Matrix2d tangent;
    tangent << to_v.dot(by_v) - 1, to_v.dot(by_w), to_w.dot(by_v), to_w.dot(by_w) - 1;
    const Eigen::Vector2d change =
        tangent.inverse() * Eigen::Vector2d(weights[1] - to_v.dot(q), weights[2] - to_w.dot(q));
    const double v = weights[1] + change[0], w = weights[2] + change[1];
    weights = Vec3(1 - v - w, v, w);
    if (!(weights.minCoeff() >= -0.5))
      return false;
    if (change.cwiseAbs().maxCoeff() < weight_tolerance)
      return true;
  }
  return false;
}

bool lies_in_triangle(const Vec3& weights) {
  return weights.minCoeff() >= -1e-6;
}

double distance_squared(const Vec3& p, const Triangle& t, const Vec3& weights, const System& system) {
  return (p - weights[0] * system.x[t[0]] - weights[1] * system.x[t[1]] - weights[2] * system.x[t[2]]).squaredNorm();
}

// mm: a vertex further than this from the triangle that it met last may meet another triangle
constexpr double follow_distance = 0.1;

} // namespace

bool follow_projection(const Vec3& p, int triangle, const System& system, const Vectors& unit_normals,
                       const Body& target, SurfaceProjection& projection) {
  const Triangle& t = target.triangles[triangle];
  Vec3 weights = Vec3::Constant(1.0 / 3);
  if (!project_along_normals(p, t, system, unit_normals, weights) || !lies_in_triangle(weights))
    return false;
  projection = {triangle, weights, distance_squared(p, t, weights, system), true};
  return projection.distance_squared < follow_distance * follow_distance;
}

bool project_onto_edge(const Vec3& p, int triangle, const System& system, const Vectors& unit_normals,
                       const Body& target, SurfaceProjection& projection) {
  const Triangle& t = target.triangles[triangle];
  Vec3 weights = Vec3::Constant(1.0 / 3);
  if (!project_along_normals(p, t, system, unit_normals, weights))
    return false;
  weights = weights.cwiseMax(0.0);
  weights /= weights.sum();
  const double d2 = distance_squared(p, t, weights, system);
  if (d2 >= follow_distance * follow_distance)
    return false;
  projection = {triangle, weights, d2};
  return true;
}

SurfaceProjection project_onto(const Vec3& p, const std::vector<int>& candidates, const System& system,
                               const Vectors& unit_normals, const Body& target, double& distance) {
  constexpr double candidate_margin = 0.05; // mm: triangles are tried that are farther than the closest by up to this
  std::vector<SurfaceProjection> projections;
  projections.reserve(candidates.size());
  SurfaceProjection closest;
  for (int k : candidates) {
    const Triangle& t = target.triangles[k];
    const ClosestPoint q = closest_on_triangle(p, system.x[t[0]], system.x[t[1]], system.x[t[2]]);
    projections.push_back({k, q.weights, q.distance_squared});
    if (q.distance_squared < closest.distance_squared)
      closest = projections.back();
  }
  distance = std::sqrt(closest.distance_squared);
  const double reach = distance + candidate_margin;
  SurfaceProjection best;
  for (const SurfaceProjection& candidate : projections) {
    if (candidate.distance_squared > reach * reach)
      continue;
    const Triangle& t = target.triangles[candidate.triangle];
    Vec3 weights = candidate.weights;
    if (!project_along_normals(p, t, system, unit_normals, weights) || !lies_in_triangle(weights))
      continue;
    const double d2 = distance_squared(p, t, weights, system);
    if (d2 < best.distance_squared)
      best = {candidate.triangle, weights, d2, true};
  }
  return best.triangle >= 0 ? best : closest;
}

} // namespace vci
