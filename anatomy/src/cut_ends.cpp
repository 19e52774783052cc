#include "cut_ends.hpp"
#include "common/error.hpp"
#include "inner_balls.hpp"
#include "tips.hpp"
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
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
constexpr double half_width = 2;         // of the cutting square, in radii: wide enough for ovals, not for neighbours
constexpr double band = 0.6;             // radii before and behind a cut in which the wall shows the axis
constexpr double cos_agree = 0.87;       // 30 degrees
constexpr double at_end = 1.4;           // radii from an end's centre to a tip that is its rim's
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

bool at_an_end(const Vec3& p, const std::vector<End>& ends) {
  return std::any_of(ends.begin(), ends.end(),
                     [&](const End& end) { return (p - end.centre).norm() < at_end * end.radius(); });
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
std::size_t ball_of(const Mesh& mesh, const Balls& balls, const std::vector<End>& ends, Vertex tip) {
  for (const End& end : ends)
    if (at_an_end(vec(mesh.point(tip)), {end}))
      return ball_at(balls, end);
  return last_ball(mesh, balls, tip);
}

double cut_place(const Way& way) {
  for (std::size_t i = 0; i < way.s.size(); ++i)
    if (way.s[i] >= behind_last_ball * way.radius.front() &&
        way.radius[way.at(way.s[i] + way.radius[i])] < still_widening * way.radius[i])
      return way.s[i];
  return 0.5 * way.length();
}

struct Plane {
  Vec3 centre, normal; ///< the normal points along the way, away from the tip
  double radius;
};

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

// Faces made by a cut take the tag of the face they come from.
struct KeepTags : PMP::Corefinement::Default_visitor<Mesh> {
  RegionMap region;
  Mesh* mesh = nullptr;
  int tag = 0;
  void before_subface_creations(Face f, Mesh& m) {
    if (&m == mesh)
      tag = region[f];
  }
  void after_subface_created(Face f, Mesh& m) {
    if (&m == mesh)
      region[f] = tag;
  }
};

// Faces reached from `from` without crossing a marked edge.
template <class Marked> std::vector<Face> side_of(const Mesh& mesh, const Marked& marked, Face from) {
  std::vector<bool> seen(mesh.num_faces(), false);
  std::vector<Face> faces{from};
  seen[from] = true;
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (Halfedge h : mesh.halfedges_around_face(mesh.halfedge(faces[i]))) {
      const Face g = mesh.face(mesh.opposite(h));
      if (g != Mesh::null_face() && !marked[mesh.edge(h)] && !seen[g]) {
        seen[g] = true;
        faces.push_back(g);
      }
    }
  return faces;
}

// Drops the side of the plane that holds `tip`, or the smaller one without a tip; the opening is the only one it makes.
double cut(Mesh& mesh, const Plane& plane, Vertex tip, const std::string& remedy) {
  Mesh square;
  const Vec3 u = half_width * plane.radius * plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
  std::array<Vertex, 4> corner;
  for (int k = 0; k < 4; ++k)
    corner[static_cast<std::size_t>(k)] =
        square.add_vertex(point(plane.centre + (k == 0 || k == 3 ? -u : u) + (k < 2 ? -v : v)));
  square.add_face(corner[0], corner[1], corner[2]);
  square.add_face(corner[0], corner[2], corner[3]);
  auto marked = mesh.add_property_map<Edge, bool>("e:cut", false).first;
  KeepTags visitor;
  visitor.region = region_map(mesh);
  visitor.mesh = &mesh;
  PMP::corefine(mesh, square, CGAL::parameters::edge_is_constrained_map(marked).visitor(visitor));
  // the cut's own loop is the one nearest to the axis
  Edge nearest;
  double least = 1e300;
  for (Edge e : mesh.edges())
    if (const double d = (vec(mesh.point(mesh.vertex(e, 0))) - plane.centre).norm(); marked[e] && d < least) {
      least = d;
      nearest = e;
    }
  const auto refuse = [&] {
    throw InputError("a plane across the vessel does not separate its end", place(plane.centre),
                     "radius " + std::to_string(plane.radius) + " mm", remedy);
  };
  if (least > 1e299)
    refuse();
  std::vector<Face> drop = side_of(mesh, marked, mesh.face(mesh.halfedge(nearest)));
  std::vector<Face> other = side_of(mesh, marked, mesh.face(mesh.opposite(mesh.halfedge(nearest))));
  const auto holds = [&](const std::vector<Face>& faces) {
    return std::any_of(faces.begin(), faces.end(), [&](Face f) {
      const auto corners = mesh.vertices_around_face(mesh.halfedge(f));
      return std::find(corners.begin(), corners.end(), tip) != corners.end();
    });
  };
  if (tip == Mesh::null_vertex() ? PMP::area(other, mesh) < PMP::area(drop, mesh) : holds(other))
    std::swap(drop, other);
  if (tip != Mesh::null_vertex() && (!holds(drop) || holds(other)))
    refuse();
  const double lost = PMP::area(drop, mesh);
  if (lost > 0.5 * PMP::area(mesh)) // both sides hang together somewhere else
    refuse();
  for (Face f : drop)
    CGAL::Euler::remove_face(mesh.halfedge(f), mesh);
  PMP::keep_largest_connected_components(mesh, 1); // bumps of a rough wall that the plane cuts off stand alone now
  mesh.remove_property_map(marked);
  return lost;
}

double mean_radius(const Mesh& mesh) {
  return 2 * std::abs(PMP::volume(mesh)) / PMP::area(mesh);
}

void report_cut(std::vector<Repair>& repairs, const std::string& what, const Plane& plane, double lost) {
  char detail[160];
  std::snprintf(detail, sizeof detail, "radius %.3f mm at %s, %.2f mm2 of wall dropped", plane.radius,
                place(plane.centre).c_str(), lost);
  repairs.push_back({what, 1, detail});
}

} // namespace

bool cut_tips(Mesh& mesh, const std::vector<End>& ends, const std::vector<Vec3>& wanted, std::vector<Repair>& repairs) {
  PMP::remove_isolated_vertices(mesh);
  mesh.collect_garbage(); // indices count on from zero
  const std::vector<Tip> tips = tips_of(mesh, least_prominence * mean_radius(mesh));
  std::vector<Vertex> rounded;
  for (const Tip& tip : tips)
    if (!at_an_end(vec(mesh.point(tip.vertex)), ends))
      rounded.push_back(tip.vertex);
  if (rounded.empty() || tips.size() < 2)
    return false;
  const Balls balls = inner_balls(mesh, ends);
  std::vector<std::pair<Vertex, Plane>> cuts;
  for (Vertex tip : rounded) {
    const std::size_t ball = last_ball(mesh, balls, tip);
    const Vec3 p = vec(mesh.point(tip));
    const bool asked = std::any_of(wanted.begin(), wanted.end(), [&](const Vec3& w) {
      return (w - p).norm() < (1 + reach) * balls.radius[ball] && !at_an_end(w, ends);
    });
    if (ends.size() >= 2 && !asked) {
      repairs.push_back(
          {"rounded end left closed", 1,
           "at " + place(p) + ": taken as wall since two flat ends are known; name it by --outlet to have it cut",
           true});
      continue;
    }
    const auto from = tip == tips[0].vertex ? tips[1].vertex : tips[0].vertex;
    const Way way = way_from(balls, cheapest_ways(balls, ball_of(mesh, balls, ends, from)), ball);
    if (way.length() < way.radius.front()) // a ball has tips but no vessel between them
      continue;
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
  std::vector<Way> ways;
  if (tips.size() >= 2) {
    const Ways from_tip = cheapest_ways(balls, ball_of(mesh, balls, ends, tips[0].vertex));
    for (std::size_t t = 1; t < tips.size(); ++t)
      ways.push_back(way_from(balls, from_tip, ball_of(mesh, balls, ends, tips[t].vertex)));
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
