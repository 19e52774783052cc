#include "vci/contact/contact.hpp"
#include "vci/contact/foot.hpp"
#include "vci/geometry/surface.hpp"

#include <algorithm>
#include <cmath>

namespace vci {

namespace {

constexpr double search_reach = 0.5; // mm: a vertex deeper than this beyond a surface is not found any more

// Vertices that bear far more than others (calcium's edge, a window's rim) meet a second, stiffer ramp: in ramps, over
// the stiffness. Where it begins, ordinary contact does not get to: all of it that stiff makes areas hang on the steps.
constexpr double deep_from = 1.5, deep_ramp = 2, deep_stiffness = 40;
// Before a window's rim it fades only where this share of the surface is left: vertices would bear their load with a
// small share of their area there and sink in. The first ramp fades over the whole row, so that contact comes and goes
// softly.
constexpr double deep_fades = 0.1;

// A contact that slides meets no more friction along its way, but sticks again where it turns back: all of the
// stiffness taken away there does not settle, none of it makes it creep.
constexpr double relieved = 0.7;

/// Quadratic over the width w, then linear; nothing below a = 0.
RampLaw ramp(double a, double stiffness, double w) {
  if (a <= 0)
    return {0, 0, 0};
  if (a < w)
    return {stiffness * a * a * a / (6 * w), stiffness * a * a / (2 * w), stiffness * a / w};
  return {stiffness * (w * w / 6 + 0.5 * a * (a - w)), stiffness * (a - 0.5 * w), stiffness};
}

} // namespace

RampLaw contact_ramp(double gap, const ContactSettings& s, const ShareSeen& seen) {
  const RampLaw law = ramp(s.distance - gap, seen.first_ramp * s.stiffness, s.ramp);
  const RampLaw deep =
      ramp(s.distance - gap - deep_from * s.ramp, seen.deep_ramp * deep_stiffness * s.stiffness, deep_ramp * s.ramp);
  return {law.energy + deep.energy, law.pressure + deep.pressure, law.stiffness + deep.stiffness};
}

RampLaw averaged_ramp(double from, double to, const ContactSettings& s, const ShareSeen& seen) {
  const RampLaw here = contact_ramp(from, s, seen);
  if (std::abs(to - from) < 1e-9)
    return here;
  const RampLaw there = contact_ramp(to, s, seen);
  return {here.energy, (here.energy - there.energy) / (to - from), (here.pressure - there.pressure) / (to - from)};
}

bool SurfaceContact::blind(const System& system, int body, int vertex) const {
  const std::vector<char>& flags = body == inner_ ? sides_.inner_blind : sides_.outer_blind;
  return !flags.empty() && flags[vertex - system.body(body).first];
}

ShareSeen SurfaceContact::share_seen(const System& system, int body, const Triangle& t, const Vec3& weights) const {
  const Body& target = system.body(body);
  double before_rims = 1, before_ends = 1, before_windows = 1;
  for (int k = 0; k < 3; ++k) {
    const bool end = target.boundary[t[k] - target.first], window = blind(system, body, t[k]);
    before_ends -= end ? weights[k] : 0;
    before_windows -= window ? weights[k] : 0;
    before_rims -= end || window ? weights[k] : 0;
  }
  return {before_rims, std::min(before_ends, before_windows / deep_fades)};
}

void add_friction(ContactPoint& point, const ContactSettings& s) {
  const double stiffness = point.area * s.friction_stiffness, trial = stiffness * point.slip->norm();
  const double limit = s.friction * point.force;
  const double share = trial > limit ? limit / trial : 1.0;
  point.link.sliding =
      share < 1 ? Vec3(std::sqrt(relieved * share * stiffness) * point.slip->normalized()) : Vec3::Zero();
  *point.slip *= share;
  point.drag = -stiffness * *point.slip;
  point.link.tangential_stiffness = share * stiffness;
}

Normals::Normals(Vectors areas) : area(std::move(areas)) {
  unit.reserve(area.size());
  for (const Vec3& n : area)
    unit.push_back(n.normalized());
}

const BroadPhase& SurfaceTrees::at(const System& system, int body) {
  const Triangles& triangles = system.body(body).triangles;
  const auto [place, made] = trees_.try_emplace(body, triangles, system.x);
  if (!made)
    place->second.update(triangles, system.x);
  return place->second;
}

/// What a search found for a vertex: far from the surface, or candidates.
void SurfaceContact::face(const System& system, const Vectors& units, int v, const Body& target, bool vertex_inside,
                          const std::vector<NearTriangle>& found, double travel, Facing& facing) const {
  const Vec3& p = system.x[v];
  facing.triangles.clear();
  facing.foot = -1;
  facing.search = {p, travel, search_reach - settings_.distance};
  if (found.empty())
    return;
  const NearTriangle& foot = *std::min_element(found.begin(), found.end(),
                                               [](const auto& a, const auto& b) { return a.distance < b.distance; });
  facing.foot = foot.triangle;
  const Triangle& t = target.triangles[foot.triangle];
  const Vec3 q = foot.weights[0] * system.x[t[0]] + foot.weights[1] * system.x[t[1]] + foot.weights[2] * system.x[t[2]];
  const double side_of = (vertex_inside ? 1 : -1) * interpolated_normal(t, foot.weights, units).dot(q - p);
  facing.search.length = foot.distance - settings_.distance - largest_sagitta(t, system.x, units);
  if (side_of > 0 && facing.search.length > settings_.skin)
    return;
  facing.search.length = settings_.skin;
  facing.measure = {p, travel, -1};
  for (const NearTriangle& f : found)
    facing.triangles.push_back(f.triangle);
}

/// A vertex that still meets the triangle it met need not be searched for at every turn.
bool SurfaceContact::keeps_foot(const System& system, const Vectors& units, const Vec3& p, const Body& target,
                                double travel, const Facing& facing) const {
  Foot foot;
  return !facing.triangles.empty() && !facing.search.used_up(p, travel - 2 * settings_.skin) &&
         follow_foot(p, facing.foot, system, units, target, foot);
}

void SurfaceContact::search(const System& system, const Vectors& units, int from, int onto, bool vertex_inside,
                            Direction& side) {
  const Body &source = system.body(from), &target = system.body(onto);
  side.facing.resize(source.count);
  std::vector<NearTriangle> found;
  const BroadPhase* boxes = nullptr;
  for (int k = 0; k < source.count; ++k) {
    Facing& facing = side.facing[k];
    const Vec3& p = system.x[source.first + k];
    if (blind(system, from, source.first + k))
      continue;
    if (!facing.search.used_up(p, side.travel) || keeps_foot(system, units, p, target, side.travel, facing))
      continue;
    if (!boxes)
      boxes = &trees_->at(system, onto);
    // a triangle may become the nearest while both sides move by the skin
    boxes->near(p, target.triangles, system.x, search_reach, 2 * settings_.skin, facing.foot, found);
    face(system, units, source.first + k, target, vertex_inside, found, side.travel, facing);
  }
}

void SurfaceContact::measure(const System& system, const Normals& normals, int from, int onto, bool vertex_inside,
                             double ahead, Direction& side, std::vector<ContactPoint>& points) const {
  const Vectors& units = normals.unit;
  const Body& target = system.body(onto);
  Vectors slip(system.body(from).count, Vec3::Zero());
  side.slip.resize(slip.size(), Vec3::Zero());
  slip.swap(side.slip);                           // a vertex without contact starts anew
  const double sign = vertex_inside ? 1.0 : -1.0; // gap = sign (foot - vertex) . n
  const int first = system.body(from).first;
  for (std::size_t place = 0; place < side.facing.size(); ++place) {
    Facing& c = side.facing[place];
    const int vertex = first + static_cast<int>(place);
    const Vec3& p = system.x[vertex];
    if (c.triangles.empty() || !c.measure.used_up(p, side.travel))
      continue;
    Foot foot;
    double clear = 0;
    if (!follow_foot(p, c.foot, system, units, target, foot))
      foot = foot_of(p, c.triangles, system, units, target, clear);
    if (foot.triangle < 0)
      continue; // positions are no longer finite; the integrator reports it
    c.foot = foot.triangle;
    c.measure = {p, side.travel, -1};
    const Triangle& t = target.triangles[foot.triangle];
    const ShareSeen seen = share_seen(system, onto, t, foot.weights);
    if (seen.first_ramp <= 1e-9)
      continue;
    const Vec3 n = interpolated_normal(t, foot.weights, units);
    if ((n.dot(units[vertex]) > 0) != sides_.nested)
      continue; // the surfaces do not face each other here
    const Vec3 q =
        foot.weights[0] * system.x[t[0]] + foot.weights[1] * system.x[t[1]] + foot.weights[2] * system.x[t[2]];
    const double gap = sign * (n.dot(q - p) + (settings_.smooth ? sagitta(t, foot.weights, system.x, units) : 0.0));
    RampLaw law = contact_ramp(gap, settings_, seen);
    if (settings_.time_averaged && ahead > 0) {
      const Vec3 closing = system.velocity[vertex] - foot.weights[0] * system.velocity[t[0]] -
                           foot.weights[1] * system.velocity[t[1]] - foot.weights[2] * system.velocity[t[2]];
      law = averaged_ramp(gap, gap - sign * n.dot(closing) * ahead, settings_, seen);
    }
    if (law.pressure <= 0) {
      c.measure.length =
          settings_.time_averaged ? -1 : clear - settings_.distance - largest_sagitta(t, system.x, units);
      continue;
    }
    const double area = normals.area[vertex].norm();
    const PointLink link{{vertex, t[0], t[1], t[2]},
                         {-sign, sign * foot.weights[0], sign * foot.weights[1], sign * foot.weights[2]},
                         n,
                         area * law.stiffness,
                         0.0};
    Vec3& kept = side.slip[place];
    kept = slip[place] - n.dot(slip[place]) * n;
    ContactPoint point{link, seen.first_ramp * area, gap, area * law.pressure, Vec3::Zero(), &kept};
    add_friction(point, settings_);
    points.push_back(point);
  }
}

double SurfaceContact::largest_move(const System& system, int body) const {
  const Body& b = system.body(body);
  double moved = 0;
  for (int v = b.first; v < b.first + b.count; ++v)
    moved = std::max(moved, (system.x[v] - last_[v]).squaredNorm());
  return std::sqrt(moved);
}

void SurfaceContact::detect(const System& system, const Normals& normals, std::vector<ContactPoint>& points,
                            double ahead) {
  if (last_.size() != system.x.size()) { // bodies have come or gone
    inner_on_outer_.facing.clear();
    outer_on_inner_.facing.clear();
  } else {
    inner_on_outer_.travel += largest_move(system, outer_);
    outer_on_inner_.travel += largest_move(system, inner_);
  }
  last_ = system.x;
  search(system, normals.unit, inner_, outer_, sides_.nested, inner_on_outer_);
  search(system, normals.unit, outer_, inner_, false, outer_on_inner_);
  measure(system, normals, inner_, outer_, sides_.nested, ahead, inner_on_outer_, points);
  measure(system, normals, outer_, inner_, false, ahead, outer_on_inner_, points);
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
