#include "vci/contact/contact.hpp"
#include "vci/contact/surface_projection.hpp"
#include "vci/geometry/surface.hpp"

#include <algorithm>
#include <cmath>

namespace vci {

namespace {

// mm: radius round a vertex in which a surface is searched. A vertex that has gone deeper is no longer in contact.
constexpr double search_reach = 0.5;

// At the edge of calcium or at the rim of a stent's opening, a few vertices carry far more load than the others. A
// second, stiffer contact response stops them, the deep response. It begins at a depth that ordinary contact seldom
// reaches. If all contact were as stiff, areas would depend on the length of the solver's steps. Start and width are in
// widths of the ordinary ramp, and the stiffness is relative to the ordinary stiffness.
constexpr double deep_start = 1.5, deep_width = 2, deep_stiffness_ratio = 40;
// Largest factor by which stiffen_deep_contacts() raises the deep response of a vertex. If a vertex is still too deep
// at this factor, it remains too deep.
constexpr double largest_deep_scale = 64;
// Across the last row of triangles before a window (an opening in a surface), the barycentric weight of the corners off
// the rim falls from 1 to 0 at the rim. The deep response fades only where this weight is below `deep_fade_share`. With
// an earlier fade, vertices there would be too soft for their load and sink in. The ordinary response fades over the
// whole row, so that contact comes and goes gradually.
constexpr double deep_fade_share = 0.1;

// Share of a sliding contact's friction stiffness that the step's matrix leaves out in the direction of slip. Further
// slip does not raise the friction, but a contact that turns back sticks again. With all of the stiffness left out, the
// steps do not converge. With none left out, the contact creeps.
constexpr double slip_tangent_reduction = 0.7;

// At a fold, a vertex may lie on no normal of the surface. Its gap is then measured to the nearest point of the fold.
// If the vertex lies beside the fold, its gap along the normal is about 0, however far away the vertex is. So beyond
// `fold_distance` (mm) such a vertex is in contact only if it lies within 60 degrees of the normal (`fold_cosine`).
constexpr double fold_distance = 0.1, fold_cosine = 0.5;

/// @param offset vector (mm) between vertex and fold
/// @param normal unit normal of the surface at the fold
bool lies_beside_fold(const Vec3& offset, const Vec3& normal) {
  const double distance = offset.norm();
  return distance > fold_distance && std::abs(offset.dot(normal)) < fold_cosine * distance;
}

/// Response to an overlap a (mm): pressure quadratic in a up to a = w (mm), then linear; 0 if a is not above 0.
/// @param stiffness slope of the linear part, MPa/mm
PenaltyResponse ramp_response(double a, double stiffness, double w) {
  if (a <= 0)
    return {0, 0, 0};
  if (a < w)
    return {stiffness * a * a * a / (6 * w), stiffness * a * a / (2 * w), stiffness * a / w};
  return {stiffness * (w * w / 6 + 0.5 * a * (a - w)), stiffness * (a - 0.5 * w), stiffness};
}

} // namespace

PenaltyResponse penalty_response(double gap, const ContactSettings& s, const ContactFade& fade) {
  const PenaltyResponse law = ramp_response(s.distance - gap, fade.ordinary * s.stiffness, s.ramp);
  const PenaltyResponse deep = ramp_response(s.distance - gap - deep_start * s.ramp,
                                             fade.deep * deep_stiffness_ratio * s.stiffness, deep_width * s.ramp);
  return {law.energy + deep.energy, law.pressure + deep.pressure, law.stiffness + deep.stiffness};
}

PenaltyResponse averaged_response(double from, double to, const ContactSettings& s, const ContactFade& fade) {
  const PenaltyResponse at_start = penalty_response(from, s, fade);
  if (std::abs(to - from) < 1e-9)
    return at_start;
  const PenaltyResponse at_end = penalty_response(to, s, fade);
  return {at_start.energy, (at_start.energy - at_end.energy) / (to - from),
          (at_start.pressure - at_end.pressure) / (to - from)};
}

bool SurfaceContact::excluded(const System& system, int body, int vertex) const {
  const std::vector<char>& flags = body == inner_ ? scope_.inner_excluded : scope_.outer_excluded;
  return !flags.empty() && flags[vertex - system.body(body).first];
}

/// Whether a vertex of a surface lies in a window of the surface or on the window's rim.
bool SurfaceContact::lies_at_window(const System& system, int body, int vertex) const {
  const bool on_rim = body == outer_ && !scope_.outer_rim.empty() && scope_.outer_rim[vertex - system.body(body).first];
  return on_rim || excluded(system, body, vertex);
}

ContactFade SurfaceContact::fade_at(const System& system, int body, const Triangle& t, const Vec3& weights) const {
  const Body& target = system.body(body);
  double before_rims = 1, before_ends = 1, before_windows = 1;
  for (int k = 0; k < 3; ++k) {
    const bool end = target.boundary[t[k] - target.first], window = lies_at_window(system, body, t[k]);
    before_ends -= end ? weights[k] : 0;
    before_windows -= window ? weights[k] : 0;
    before_rims -= end || window ? weights[k] : 0;
  }
  return {before_rims, std::min(before_ends, before_windows / deep_fade_share)};
}

void add_friction(ContactPoint& point, const ContactSettings& s) {
  const double stiffness = point.area * s.friction_stiffness, trial = stiffness * point.slip->norm();
  const double limit = s.friction * point.force;
  const double share = trial > limit ? limit / trial : 1.0;
  point.stencil.slip_softening =
      share < 1 ? Vec3(std::sqrt(slip_tangent_reduction * share * stiffness) * point.slip->normalized()) : Vec3::Zero();
  *point.slip *= share;
  point.friction = -stiffness * *point.slip;
  point.stencil.tangential_stiffness = share * stiffness;
}

Normals::Normals(Vectors areas) : area(std::move(areas)) {
  unit.reserve(area.size());
  for (const Vec3& n : area)
    unit.push_back(n.normalized());
}

const BroadPhase& SurfaceTrees::at(const System& system, int body) {
  const Triangles& triangles = system.body(body).triangles;
  const auto [place, created] = trees_.try_emplace(body, triangles, system.x);
  if (!created)
    place->second.update(triangles, system.x);
  return place->second;
}

/// Stores the triangles `found` by a search round vertex v in `candidates`. If the surface is far away, only the
/// nearest triangle is stored, and how far vertex and surface may move until the next search.
void SurfaceContact::store_candidates(const System& system, const Vectors& unit_normals, int v, const Body& target,
                                      bool vertex_inside, const std::vector<NearTriangle>& found, double travel,
                                      Candidates& candidates) const {
  const Vec3& p = system.x[v];
  candidates.triangles.clear();
  candidates.last_triangle = -1;
  candidates.search_bound = {p, travel, search_reach - settings_.distance};
  if (found.empty())
    return;
  const NearTriangle& projection = *std::min_element(
      found.begin(), found.end(), [](const auto& a, const auto& b) { return a.distance < b.distance; });
  candidates.last_triangle = projection.triangle;
  const Triangle& t = target.triangles[projection.triangle];
  const Vec3 q = projection.weights[0] * system.x[t[0]] + projection.weights[1] * system.x[t[1]] +
                 projection.weights[2] * system.x[t[2]];
  const double side_of = (vertex_inside ? 1 : -1) * interpolated_normal(t, projection.weights, unit_normals).dot(q - p);
  candidates.search_bound.allowance =
      projection.distance - settings_.distance - largest_sagitta(t, system.x, unit_normals);
  if (side_of > 0 && candidates.search_bound.allowance > settings_.skin)
    return;
  candidates.search_bound.allowance = settings_.skin;
  candidates.gap_bound = {p, travel, -1};
  for (const NearTriangle& f : found)
    candidates.triangles.push_back(f.triangle);
}

/// Whether a vertex at p still projects onto the triangle that it met last, so that no new search is needed. Vertex and
/// surface may together have moved by up to three times `skin` since the last search.
bool SurfaceContact::still_projects(const System& system, const Vectors& unit_normals, const Vec3& p,
                                    const Body& target, double travel, const Candidates& candidates) const {
  SurfaceProjection projection;
  return !candidates.triangles.empty() && !candidates.search_bound.exceeded(p, travel - 2 * settings_.skin) &&
         follow_projection(p, candidates.last_triangle, system, unit_normals, target, projection);
}

void SurfaceContact::search_candidates(const System& system, const Vectors& unit_normals, int from, int onto,
                                       bool vertex_inside, OneWayContact& one_way) {
  const Body &source = system.body(from), &target = system.body(onto);
  one_way.candidates.resize(source.count);
  std::vector<NearTriangle> found;
  const BroadPhase* boxes = nullptr;
  for (int k = 0; k < source.count; ++k) {
    Candidates& candidates = one_way.candidates[k];
    const Vec3& p = system.x[source.first + k];
    if (excluded(system, from, source.first + k))
      continue;
    if (!candidates.search_bound.exceeded(p, one_way.travel) ||
        still_projects(system, unit_normals, p, target, one_way.travel, candidates))
      continue;
    if (!boxes)
      boxes = &trees_->at(system, onto);
    // Until the next search, each distance may change by `skin`. So a triangle that is now up to twice this length
    // farther than the nearest one may become the nearest.
    boxes->find_near(p, target.triangles, system.x, search_reach, 2 * settings_.skin, candidates.last_triangle, found);
    store_candidates(system, unit_normals, source.first + k, target, vertex_inside, found, one_way.travel, candidates);
  }
}

void SurfaceContact::measure_gaps(const System& system, const Normals& normals, int from, int onto, bool vertex_inside,
                                  double lookahead_ms, OneWayContact& one_way,
                                  std::vector<ContactPoint>& points) const {
  const Vectors& unit_normals = normals.unit;
  const Body& target = system.body(onto);
  Vectors slip(system.body(from).count, Vec3::Zero());
  one_way.slip.resize(slip.size(), Vec3::Zero());
  slip.swap(one_way.slip); // a vertex that has lost contact also loses its stored slip
  one_way.deep_scale.resize(slip.size(), 1.0);
  const double sign = vertex_inside ? 1.0 : -1.0; // gap = sign (projection - vertex) . n
  const int first = system.body(from).first;
  for (std::size_t place = 0; place < one_way.candidates.size(); ++place) {
    Candidates& c = one_way.candidates[place];
    const int vertex = first + static_cast<int>(place);
    const Vec3& p = system.x[vertex];
    // The factor on the deep response is kept until the vertex is clear of the surface. A vertex beside a rim may lose
    // its contact in one step and be deep again in the next. If the factor were then reset to 1, a stage might
    // alternate for ever between balance and stiffening.
    double& deep_scale = one_way.deep_scale[place];
    if (c.triangles.empty() || !c.gap_bound.exceeded(p, one_way.travel)) {
      deep_scale = 1;
      continue;
    }
    SurfaceProjection projection;
    double distance = 0;
    if (!follow_projection(p, c.last_triangle, system, unit_normals, target, projection)) {
      projection = project_onto(p, c.triangles, system, unit_normals, target, distance);
      if (!projection.along_normals && projection.triangle >= 0)
        project_onto_edge(p, c.last_triangle, system, unit_normals, target, projection);
    }
    if (projection.triangle < 0)
      continue; // only if positions are not finite, which the integrator reports
    c.last_triangle = projection.triangle;
    c.gap_bound = {p, one_way.travel, -1};
    const Triangle& t = target.triangles[projection.triangle];
    ContactFade fade = fade_at(system, onto, t, projection.weights);
    if (fade.ordinary <= 1e-9)
      continue;
    const Vec3 n = interpolated_normal(t, projection.weights, unit_normals);
    if ((n.dot(unit_normals[vertex]) > 0) != scope_.nested)
      continue; // outward normals must point the same way on nested surfaces, opposite ways on surfaces side by side
    const Vec3 q = projection.weights[0] * system.x[t[0]] + projection.weights[1] * system.x[t[1]] +
                   projection.weights[2] * system.x[t[2]];
    if (!projection.along_normals && lies_beside_fold(q - p, n))
      continue;
    const double gap =
        sign * (n.dot(q - p) + (settings_.smooth ? sagitta(t, projection.weights, system.x, unit_normals) : 0.0));
    fade.deep *= deep_scale;
    PenaltyResponse law = penalty_response(gap, settings_, fade);
    if (settings_.time_averaged && lookahead_ms > 0) {
      const Vec3 closing = system.velocity[vertex] - projection.weights[0] * system.velocity[t[0]] -
                           projection.weights[1] * system.velocity[t[1]] -
                           projection.weights[2] * system.velocity[t[2]];
      law = averaged_response(gap, gap - sign * n.dot(closing) * lookahead_ms, settings_, fade);
    }
    if (law.pressure <= 0) {
      deep_scale = 1;
      c.gap_bound.allowance =
          settings_.time_averaged ? -1 : distance - settings_.distance - largest_sagitta(t, system.x, unit_normals);
      continue;
    }
    const double area = normals.area[vertex].norm();
    const StencilStiffness stencil{
        {vertex, t[0], t[1], t[2]},
        {-sign, sign * projection.weights[0], sign * projection.weights[1], sign * projection.weights[2]},
        n,
        area * law.stiffness,
        0.0};
    Vec3& stored_slip = one_way.slip[place];
    stored_slip = slip[place] - n.dot(slip[place]) * n;
    ContactPoint point{stencil,      fade.ordinary * area, gap,        area * law.pressure,
                       Vec3::Zero(), &stored_slip,         &deep_scale};
    add_friction(point, settings_);
    points.push_back(point);
  }
}

double SurfaceContact::largest_displacement(const System& system, int body) const {
  const Body& b = system.body(body);
  double moved = 0;
  for (int v = b.first; v < b.first + b.count; ++v)
    moved = std::max(moved, (system.x[v] - last_positions_[v]).squaredNorm());
  return std::sqrt(moved);
}

void SurfaceContact::detect(const System& system, const Normals& normals, std::vector<ContactPoint>& points,
                            double lookahead_ms) {
  if (last_positions_.size() != system.x.size()) { // bodies were added or removed
    inner_on_outer_.candidates.clear();
    outer_on_inner_.candidates.clear();
  } else {
    inner_on_outer_.travel += largest_displacement(system, outer_);
    outer_on_inner_.travel += largest_displacement(system, inner_);
  }
  last_positions_ = system.x;
  search_candidates(system, normals.unit, inner_, outer_, scope_.nested, inner_on_outer_);
  search_candidates(system, normals.unit, outer_, inner_, false, outer_on_inner_);
  measure_gaps(system, normals, inner_, outer_, scope_.nested, lookahead_ms, inner_on_outer_, points);
  measure_gaps(system, normals, outer_, inner_, false, lookahead_ms, outer_on_inner_, points);
}

Tie make_tie(const ContactPoint& point, const Vectors& x, double stiffness_mpa_per_mm) {
  Tie tie{point.stencil, Vec3::Zero(), point.force};
  for (int k = 0; k < 4; ++k)
    tie.offset += point.stencil.weight[k] * x[point.stencil.vertex[k]];
  tie.stencil.normal_stiffness = tie.stencil.tangential_stiffness = point.area * stiffness_mpa_per_mm;
  return tie;
}

void add_tie_forces(const std::vector<Tie>& ties, const Vectors& x, Vectors& force) {
  for (const Tie& tie : ties) {
    Vec3 r = -tie.offset;
    for (int k = 0; k < 4; ++k)
      r += tie.stencil.weight[k] * x[tie.stencil.vertex[k]];
    const Vec3 f = tie.force * tie.stencil.normal - tie.stencil.normal_stiffness * r;
    for (int k = 0; k < 4; ++k)
      force[tie.stencil.vertex[k]] += tie.stencil.weight[k] * f;
  }
}

void add_contact_forces(const std::vector<ContactPoint>& points, Vectors& force) {
  for (const ContactPoint& point : points)
    for (int k = 0; k < 4; ++k)
      force[point.stencil.vertex[k]] += point.stencil.weight[k] * (point.force * point.stencil.normal + point.friction);
}

bool stiffen_deep_contacts(const std::vector<ContactPoint>& points, double limit) {
  bool stiffened = false;
  for (const ContactPoint& point : points)
    if (-point.gap > limit && point.deep_scale && *point.deep_scale < largest_deep_scale) {
      *point.deep_scale *= 2;
      stiffened = true;
    }
  return stiffened;
}

void add_slip(const std::vector<ContactPoint>& points, const Vectors& displacement) {
  for (const ContactPoint& point : points)
    for (int k = 0; k < 4; ++k)
      *point.slip += point.stencil.weight[k] * displacement[point.stencil.vertex[k]];
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
