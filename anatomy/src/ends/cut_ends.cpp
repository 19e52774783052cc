#include "ends/cut_ends.hpp"
#include "centreline/inner_balls.hpp"
#include "common/error.hpp"
#include "ends/plane_cut.hpp"
#include "repair/tips.hpp"
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/repair.h>
#include <algorithm>

namespace anatomy {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using common::InputError;

constexpr double least_prominence = 2;   // mean radii that a vessel must stand out by to have an end of its own
constexpr double behind_last_ball = 0.5; // radii from its centre to the cut: the plane may tilt by 26 degrees
constexpr double still_widening = 1.15;  // growth of the radius over one radius of a tip that tapers
constexpr double band = 0.6;             // radii before and behind a cut in which the wall shows the axis
constexpr double cos_agree = 0.87;       // 30 degrees
constexpr double beside_end = 0.4;       // radii from an end's rim to a tip that is the rim's
constexpr double beside_rough = 0.1;     // radii; where noise has left a vertex without a ball of its own
constexpr double reach = 3;              // radii within which a point names a tip or a place on the axis

// A way through the balls, from a tip inwards, by arc length.
struct Way {
  std::vector<Vec3> points;
  std::vector<double> radius, s;

  double length() const { return s.back(); }
  std::size_t at(double where) const {
    const auto above = std::lower_bound(s.begin(), s.end(), where);
    return std::min(static_cast<std::size_t>(above - s.begin()), s.size() - 1);
  }
  // Mean of the balls' centres within a quarter of a radius, since single ones scatter about the axis.
  Vec3 centre(double where) const {
    const double width = 0.25 * radius[at(where)];
    Vec3 sum = Vec3::Zero();
    int n = 0;
    for (std::size_t i = 0; i < s.size(); ++i)
      if (std::abs(s[i] - where) <= width) {
        sum += points[i];
        ++n;
      }
    return n > 0 ? Vec3(sum / n) : points[at(where)];
  }
};

Way way_from(const Balls& balls, const Ways& ways, std::size_t ball) {
  Way way;
  for (std::size_t at = ball, last = balls.centre.size(); at != last; at = ways.before[at]) {
    last = at;
    way.s.push_back(way.points.empty() ? 0 : way.s.back() + (balls.centre[at] - way.points.back()).norm());
    way.points.push_back(balls.centre[at]);
    way.radius.push_back(balls.radius[at]);
  }
  return way;
}

// Places round which what stands out of the wall is an end's rim: each end's centre, and how far it reaches from there.
struct EndReach {
  const End* end;
  double reach; // mm: to the farthest point of the rim, which of an oval is well beyond its radius, and a little more
};

std::vector<EndReach> reaches_of(const Mesh& mesh, const std::vector<End>& ends) {
  std::map<int, EndReach> found;
  for (const End& end : ends)
    found[end.region] = {&end, 0};
  const RegionMap region = region_map(mesh);
  for (Face f : mesh.faces())
    if (const auto it = found.find(region[f]); it != found.end())
      for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
        it->second.reach = std::max(it->second.reach, (vec(mesh.point(v)) - it->second.end->centre).norm());
  std::vector<EndReach> reaches;
  for (const auto& [tag, at] : found)
    reaches.push_back({at.end, at.reach + beside_end * at.end->radius()});
  return reaches;
}

// The end whose rim p is near, or none.
const End* end_at(const Vec3& p, const std::vector<EndReach>& reaches) {
  for (const auto& [end, far] : reaches)
    if ((p - end->centre).norm() < far)
      return end;
  return nullptr;
}

// The largest of the balls whose surface is within `near` radii of p; their number if there is none.
std::size_t largest_ball_at(const Vec3& p, const Balls& balls, double near) {
  std::size_t best = balls.centre.size();
  for (std::size_t i = 0; i < balls.centre.size(); ++i)
    if (std::abs((balls.centre[i] - p).norm() - balls.radius[i]) < near * balls.radius[i] &&
        (best == balls.centre.size() || balls.radius[i] > balls.radius[best]))
      best = i;
  return best;
}

// The largest inner ball that touches the vertex, or comes near it where the vertex stands out of a rough wall.
std::size_t last_ball(const Mesh& mesh, const Balls& balls, Vertex tip) {
  const Vec3 p = vec(mesh.point(tip));
  std::size_t best = largest_ball_at(p, balls, 1e-6);
  if (best == balls.centre.size())
    best = largest_ball_at(p, balls, beside_rough);
  if (best == balls.centre.size())
    throw InputError("no axis found at a rounded end", place(p), "no inscribed ball",
                     "cut the end flat, or leave it open");
  return best;
}

// The ball at a tip, whether a cap ends it or not.
std::size_t ball_of(const Mesh& mesh, const Balls& balls, const std::vector<EndReach>& reaches, Vertex tip) {
  const End* end = end_at(vec(mesh.point(tip)), reaches);
  return end ? ball_at(balls, *end) : last_ball(mesh, balls, tip);
}

double cut_place(const Way& way) {
  for (std::size_t i = 0; i < way.s.size(); ++i)
    if (way.s[i] >= behind_last_ball * way.radius.front() &&
        way.radius[way.at(way.s[i] + way.radius[i])] < still_widening * way.radius[i])
      return way.s[i];
  return 0.5 * way.length();
}

// Across the direction to which the wall's normals about the cut are most nearly perpendicular: the balls scatter too
// much to show it within a degree. Where these disagree with the way (a side branch beside the cut), the way decides.
Plane plane_across(const Mesh& mesh, const Way& way, double where) {
  const double r = way.radius[way.at(where)];
  const Vec3 centre = way.centre(where);
  const Vec3 along =
      (way.centre(std::min(where + r, way.length())) - way.centre(std::max(where - 0.5 * r, 0.0))).normalized();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (Face f : mesh.faces()) {
    const Halfedge h = mesh.halfedge(f);
    const Vec3 a = vec(mesh.point(mesh.source(h))), b = vec(mesh.point(mesh.target(h))),
               c = vec(mesh.point(mesh.target(mesh.next(h))));
    const Vec3 p = (a + b + c) / 3 - centre, area = (b - a).cross(Vec3(c - a));
    if (std::abs(p.dot(along)) < band * r && p.norm() < half_width * r && area.norm() > 0)
      spread += area * area.transpose() / area.norm();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  Vec3 normal = axes.eigenvectors().col(0);
  if (normal.dot(along) < 0)
    normal = -normal;
  return {centre, normal.dot(along) > cos_agree ? normal : along, r};
}

double mean_radius(const Mesh& mesh) {
  return 2 * std::abs(PMP::volume(mesh)) / PMP::area(mesh);
}

void report_short(std::vector<Repair>& repairs, const Vec3& tip, const Way& way) {
  char detail[192];
  std::snprintf(detail, sizeof detail,
                "at %s, radius %.3f mm: its axis is %.3f mm long, less than its radius; taken as wall",
                place(tip).c_str(), way.radius.front(), way.length());
  repairs.push_back({"short tip left closed", 1, detail, true});
}

} // namespace

bool cut_tips(Mesh& mesh, const std::vector<End>& ends, const std::vector<Vec3>& wanted, std::vector<Repair>& repairs) {
  PMP::remove_isolated_vertices(mesh);
  mesh.collect_garbage(); // indices count on from zero
  const std::vector<Tip> tips = tips_of(mesh, least_prominence * mean_radius(mesh));
  const std::vector<EndReach> reaches = reaches_of(mesh, ends);
  std::vector<Vertex> rounded;
  for (const Tip& tip : tips)
    if (!end_at(vec(mesh.point(tip.vertex)), reaches))
      rounded.push_back(tip.vertex);
  if (rounded.empty() || tips.size() < 2)
    return false;
  const Balls balls = inner_balls(mesh, ends);
  std::vector<std::pair<Vertex, Plane>> cuts;
  for (Vertex tip : rounded) {
    const std::size_t ball = last_ball(mesh, balls, tip);
    const Vec3 p = vec(mesh.point(tip));
    const bool asked = std::any_of(wanted.begin(), wanted.end(), [&](const Vec3& w) {
      return (w - p).norm() < (1 + reach) * balls.radius[ball] && !end_at(w, reaches);
    });
    if (ends.size() >= 2 && !asked) {
      repairs.push_back(
          {"rounded end left closed", 1,
           "at " + place(p) + ": taken as wall since two flat ends are known; name it by --outlet to have it cut",
           true});
      continue;
    }
    const auto from = tip == tips[0].vertex ? tips[1].vertex : tips[0].vertex;
    const Way way = way_from(balls, cheapest_ways(balls, ball_of(mesh, balls, reaches, from)), ball);
    if (way.length() < way.radius.front()) { // a ball has tips but no vessel between them
      report_short(repairs, p, way);
      continue;
    }
    cuts.emplace_back(tip, plane_across(mesh, way, cut_place(way)));
  }
  for (const auto& [tip, plane] : cuts)
    report_cut(repairs, "rounded end cut flat", plane, cut(mesh, plane, tip, "cut the end flat, or leave it open"));
  mesh.collect_garbage();
  return !cuts.empty();
}

void cut_across(Mesh& mesh, const std::vector<End>& ends, const std::vector<Vec3>& points,
                std::vector<Repair>& repairs) {
  if (points.empty())
    return;
  PMP::remove_isolated_vertices(mesh);
  mesh.collect_garbage();
  const std::vector<Tip> tips = tips_of(mesh, least_prominence * mean_radius(mesh));
  const Balls balls = inner_balls(mesh, ends);
  const std::vector<EndReach> reaches = reaches_of(mesh, ends);
  std::vector<Way> ways;
  if (tips.size() >= 2) {
    const Ways from_tip = cheapest_ways(balls, ball_of(mesh, balls, reaches, tips[0].vertex));
    for (std::size_t t = 1; t < tips.size(); ++t)
      ways.push_back(way_from(balls, from_tip, ball_of(mesh, balls, reaches, tips[t].vertex)));
  }
  for (const Vec3& p : points) {
    const Way* nearest = nullptr;
    std::size_t at = 0;
    double least = 1e300;
    for (const Way& way : ways)
      for (std::size_t i = 0; i < way.points.size(); ++i)
        if ((way.points[i] - p).norm() < least) {
          least = (way.points[i] - p).norm();
          nearest = &way;
          at = i;
        }
    if (!nearest || least > reach * nearest->radius[at])
      throw InputError("no vessel near the point to cut at", "--cut", place(p), "give a point on the vessel's axis");
    const Plane plane = plane_across(mesh, *nearest, nearest->s[at]);
    report_cut(repairs, "vessel cut across", plane,
               cut(mesh, plane, Mesh::null_vertex(), "give a point where the vessel is round and alone"));
  }
  mesh.collect_garbage();
}

} // namespace anatomy
