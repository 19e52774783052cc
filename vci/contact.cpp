#include "vci/contact.hpp"
#include "vci/closest_point.hpp"
#include "vci/surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace vci {

namespace {

constexpr double search_reach = 0.5; // mm: a vertex deeper than this beyond a surface is not found any more

struct Foot {
  int triangle = -1;
  Vec3 weights = Vec3::Zero();
  double distance_squared = 1e300;
};

Vec3 interpolated_normal(const Triangle& t, const Vec3& weights, const Vectors& units) {
  Vec3 n = Vec3::Zero();
  for (int k = 0; k < 3; ++k)
    n += weights[k] * units[t[k]];
  return n.normalized();
}

/// 1 inside a surface, falling to 0 over the last row of triangles before an open edge: beyond the edge nothing
/// touches, and a contact that ended abruptly there would flip for ever.
double share_inside(const Triangle& t, const Vec3& weights, const Body& body) {
  double share = 1;
  for (int k = 0; k < 3; ++k)
    if (body.boundary[t[k] - body.first])
      share -= weights[k];
  return share;
}

/// The point of a triangle from which p lies along the interpolated normal: unlike the closest point it moves
/// continuously across edges on both sides of a folded surface. Returns false where it lies outside the triangle.
bool project_along_normals(const Vec3& p, const Triangle& t, const System& system, const Vectors& units,
                           Vec3& weights) {
  const Vec3 &a = system.x[t[0]], ab = system.x[t[1]] - a, ac = system.x[t[2]] - a;
  const Vec3 face = ab.cross(ac);
  Vec3 n = interpolated_normal(t, weights, units);
  for (int iteration = 0; iteration < 4; ++iteration) {
    const double slope = n.dot(face);
    if (slope <= 0.2 * face.norm())
      return false;
    const Vec3 q = p - (p - a).dot(face) / slope * n - a;
    const double v = q.cross(ac).dot(face) / face.squaredNorm(), w = ab.cross(q).dot(face) / face.squaredNorm();
    weights = Vec3(1 - v - w, v, w);
    if (weights.minCoeff() < -0.5)
      return false;
    n = interpolated_normal(t, weights, units);
  }
  return weights.minCoeff() >= -1e-6;
}

/// The foot on the triangle where it was last, if it still lies there and near: following it saves the search among
/// all candidates.
bool follow_foot(const Vec3& p, int triangle, const System& system, const Vectors& units, const Body& target,
                 Foot& foot) {
  constexpr double near = 0.1; // mm
  const Triangle& t = target.triangles[triangle];
  Vec3 weights = Vec3::Constant(1.0 / 3);
  if (!project_along_normals(p, t, system, units, weights))
    return false;
  const double d2 =
      (p - weights[0] * system.x[t[0]] - weights[1] * system.x[t[1]] - weights[2] * system.x[t[2]]).squaredNorm();
  foot = {triangle, weights, d2};
  return d2 < near * near;
}

/// Where a vertex meets a surface: along the interpolated normal if some triangle near has such a point, else the
/// closest.
Foot foot_of(const Vec3& p, const std::vector<int>& candidates, const System& system, const Vectors& units,
             const Body& target) {
  constexpr double near = 0.05; // mm beyond the closest triangle
  std::array<Foot, 16> feet;
  std::size_t count = 0;
  Foot closest;
  for (int k : candidates) {
    const Triangle& t = target.triangles[k];
    const ClosestPoint q = closest_on_triangle(p, system.x[t[0]], system.x[t[1]], system.x[t[2]]);
    const Foot foot{k, q.weights, q.distance_squared};
    if (foot.distance_squared < closest.distance_squared)
      closest = foot;
    if (count < feet.size())
      feet[count++] = foot;
  }
  const double reach = std::sqrt(closest.distance_squared) + near;
  Foot best;
  for (std::size_t k = 0; k < count; ++k) {
    if (feet[k].distance_squared > reach * reach)
      continue;
    const Triangle& t = target.triangles[feet[k].triangle];
    Vec3 weights = feet[k].weights;
    if (!project_along_normals(p, t, system, units, weights))
      continue;
    const double d2 =
        (p - weights[0] * system.x[t[0]] - weights[1] * system.x[t[1]] - weights[2] * system.x[t[2]]).squaredNorm();
    if (d2 < best.distance_squared)
      best = {feet[k].triangle, weights, d2};
  }
  return best.triangle >= 0 ? best : closest;
}

} // namespace

RampLaw contact_ramp(double gap, const ContactSettings& s) {
  const double a = s.distance - gap, w = s.ramp;
  if (a <= 0)
    return {0, 0, 0};
  if (a < w)
    return {s.stiffness * a * a * a / (6 * w), s.stiffness * a * a / (2 * w), s.stiffness * a / w};
  return {s.stiffness * (w * w / 6 + 0.5 * a * (a - w)), s.stiffness * (a - 0.5 * w), s.stiffness};
}

void add_friction(ContactPoint& point, const ContactSettings& s) {
  const double stiffness = point.area * s.friction_stiffness, trial = stiffness * point.slip->norm();
  const double limit = s.friction * point.force;
  const double share = trial > limit ? limit / trial : 1.0;
  *point.slip *= share;
  point.drag = -stiffness * *point.slip;
  point.link.tangential_stiffness = share * stiffness;
}

void SurfaceContact::search(const System& system, const Vectors& units, int from, int onto, bool vertex_inside,
                            Direction& side) {
  const Body &source = system.body(from), &target = system.body(onto);
  if (side.boxes)
    side.boxes->update(target.triangles, system.x);
  else
    side.boxes = std::make_unique<BroadPhase>(target.triangles, system.x);
  side.candidates.clear();
  side.nearest.resize(source.count, -1);
  std::vector<NearTriangle> found;
  for (int v = source.first; v < source.first + source.count; ++v) {
    int& nearest = side.nearest[v - source.first];
    side.boxes->near(system.x[v], target.triangles, system.x, search_reach, 2 * settings_.skin, nearest, found);
    nearest = -1;
    if (found.empty())
      continue;
    const NearTriangle& foot = *std::min_element(found.begin(), found.end(),
                                                 [](const auto& p, const auto& q) { return p.distance < q.distance; });
    nearest = foot.triangle;
    const Triangle& t = target.triangles[foot.triangle];
    const Vec3 q =
        foot.weights[0] * system.x[t[0]] + foot.weights[1] * system.x[t[1]] + foot.weights[2] * system.x[t[2]];
    const double side_of = (vertex_inside ? 1 : -1) * interpolated_normal(t, foot.weights, units).dot(q - system.x[v]);
    if (side_of > 0 && foot.distance > settings_.distance + settings_.skin)
      continue;
    Candidates c{v, {}, -1};
    for (const NearTriangle& f : found)
      c.triangles.push_back(f.triangle);
    side.candidates.push_back(std::move(c));
  }
}

void SurfaceContact::measure(const System& system, const Vectors& normals, const Vectors& units, int from, int onto,
                             bool vertex_inside, Direction& side, std::vector<ContactPoint>& points) const {
  const Body& target = system.body(onto);
  Vectors slip(system.body(from).count, Vec3::Zero());
  side.slip.resize(slip.size(), Vec3::Zero());
  slip.swap(side.slip);                           // a vertex without contact starts anew
  const double sign = vertex_inside ? 1.0 : -1.0; // gap = sign (foot - vertex) . n
  for (Candidates& c : side.candidates) {
    const Vec3& p = system.x[c.vertex];
    Foot foot;
    if (c.foot < 0 || !follow_foot(p, c.foot, system, units, target, foot))
      foot = foot_of(p, c.triangles, system, units, target);
    if (foot.triangle < 0)
      continue; // positions are no longer finite; the integrator reports it
    c.foot = foot.triangle;
    const Triangle& t = target.triangles[foot.triangle];
    const double share = share_inside(t, foot.weights, target);
    if (share <= 1e-9)
      continue;
    const Vec3 n = interpolated_normal(t, foot.weights, units);
    if (n.dot(normals[c.vertex]) <= 0)
      continue; // the surfaces do not face each other here
    const Vec3 q =
        foot.weights[0] * system.x[t[0]] + foot.weights[1] * system.x[t[1]] + foot.weights[2] * system.x[t[2]];
    const double gap = sign * n.dot(q - p);
    const RampLaw law = contact_ramp(gap, settings_);
    if (law.pressure <= 0)
      continue;
    const double area = share * normals[c.vertex].norm();
    const PointLink link{{c.vertex, t[0], t[1], t[2]},
                         {-sign, sign * foot.weights[0], sign * foot.weights[1], sign * foot.weights[2]},
                         n,
                         area * law.stiffness,
                         0.0};
    const int place = c.vertex - system.body(from).first;
    Vec3& kept = side.slip[place];
    kept = slip[place] - n.dot(slip[place]) * n;
    ContactPoint point{link, area, gap, area * law.pressure, Vec3::Zero(), &kept};
    add_friction(point, settings_);
    points.push_back(point);
  }
}

void SurfaceContact::detect(const System& system, const Vectors& normals, std::vector<ContactPoint>& points) {
  Vectors units(system.x.size());
  for (int b : {inner_, outer_})
    for (int v = system.body(b).first; v < system.body(b).first + system.body(b).count; ++v)
      units[v] = normals[v].normalized();
  double moved = 0;
  if (searched_at_.size() == system.x.size())
    for (int b : {inner_, outer_})
      for (int v = system.body(b).first; v < system.body(b).first + system.body(b).count; ++v)
        moved = std::max(moved, (system.x[v] - searched_at_[v]).squaredNorm());
  if (searched_at_.size() != system.x.size() || moved > 0.25 * settings_.skin * settings_.skin) {
    search(system, units, inner_, outer_, true, inner_on_outer_);
    search(system, units, outer_, inner_, false, outer_on_inner_);
    searched_at_ = system.x;
  }
  measure(system, normals, units, inner_, outer_, true, inner_on_outer_, points);
  measure(system, normals, units, outer_, inner_, false, outer_on_inner_, points);
}

Tie tie_of(const ContactPoint& point, const Vectors& x, double stiffness_mpa_per_mm) {
  Tie tie{point.link, Vec3::Zero(), point.force};
  for (int k = 0; k < 4; ++k)
    tie.offset += point.link.weight[k] * x[point.link.vertex[k]];
  tie.link.normal_stiffness = tie.link.tangential_stiffness = point.area * stiffness_mpa_per_mm;
  return tie;
}

void add_tie_forces(const std::vector<Tie>& ties, const Vectors& x, Vectors& force) {
  for (const Tie& tie : ties) {
    Vec3 r = -tie.offset;
    for (int k = 0; k < 4; ++k)
      r += tie.link.weight[k] * x[tie.link.vertex[k]];
    const Vec3 f = tie.force * tie.link.normal - tie.link.normal_stiffness * r;
    for (int k = 0; k < 4; ++k)
      force[tie.link.vertex[k]] += tie.link.weight[k] * f;
  }
}

void add_contact_forces(const std::vector<ContactPoint>& points, Vectors& force) {
  for (const ContactPoint& point : points)
    for (int k = 0; k < 4; ++k)
      force[point.link.vertex[k]] += point.link.weight[k] * (point.force * point.link.normal + point.drag);
}

void add_slip(const std::vector<ContactPoint>& points, const Vectors& displacement) {
  for (const ContactPoint& point : points)
    for (int k = 0; k < 4; ++k)
      *point.slip += point.link.weight[k] * displacement[point.link.vertex[k]];
}

Vectors area_vectors(const System& system) {
  Vectors normals;
  normals.reserve(system.x.size());
  for (int b = 0; b < system.bodies(); ++b) {
    const Body& body = system.body(b);
    const Vectors part = vertex_area_vectors(body.triangles, system.x, body.first, body.count);
    normals.insert(normals.end(), part.begin(), part.end());
  }
  return normals;
}

} // namespace vci
