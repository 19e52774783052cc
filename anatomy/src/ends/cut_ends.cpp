#include "ends/cut_ends.hpp"
#include "centreline/ball_way.hpp"
#include "common/error.hpp"
#include "core/measures.hpp"
#include "core/slices.hpp"
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <algorithm>

namespace anatomy {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using common::InputError;

constexpr double least_prominence = 2; // mean radii: a tip of less prominence is a stub without an end of its own
// Least prominence of a vessel with an end, in radii of its last ball. A sac, which is as wide as it is long, has less.
constexpr double least_own = 3;
// Radii from the last ball's centre to the first plane that is tried, and from a plane to the section it is compared
// with. A first plane that is tilted by 26 degrees still meets the wall behind the centre.
constexpr double behind_last_ball = 0.5;
constexpr double next_plane = 0.25; // radii between planes that are tried
// Ratio of the balls' radii over one radius of the axis. Where it is larger, the tip still tapers, and no cut is made.
constexpr double still_widening = 1.15;
// Largest ratio of the areas of two sections, half a radius apart, that count as alike: a taper of 12 degrees on each
// side.
constexpr double like_section = 1.25;
// Radii of an end: a tip less than this beyond the rim's farthest point belongs to the rim.
constexpr double beside_end = 0.4;
// Radii of a ball: it counts as near to the tip if it is farther from the tip than the nearest ball by less than this.
constexpr double about_as_near = 0.1;
// Radii of a ball: largest distance of its surface from the tip. At the rim of a flat end the distance is 0.41.
constexpr double still_at_tip = 1;
// Mean radii: first limit of the edges' length, halved until the inscribed balls connect all tips.
constexpr double longest_edge = 0.3;
constexpr double finest_edge = 0.075; // mean radii: smallest limit of the edges' length that is tried
// Radii of a tip's ball: if its neighbours lead this far from the tip, the vessel goes on there.
constexpr double beyond_tip = 2;
// Length of vessel (mm): a cut that loses more gives a warning, since an ostial lesion lies within 3 mm of the ostium.
constexpr double much_lost = 2;
constexpr double naming_reach = 3; // radii of the vessel: largest distance from a point of --cut to the axis
// Radii of the cuts: tips whose cuts are nearer to each other are one end. A dome wider than the mean vessel may have
// two tips.
constexpr double same_cut = 0.5;

// An end and the distance from its centre within which a tip is part of the end's rim.
struct EndReach {
  const End* end;
  double reach; // mm: a little more than to the cap's farthest vertex, which in an oval is well beyond the radius
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

// The end within whose reach p lies, or null.
const End* end_at(const Vec3& p, const std::vector<EndReach>& reaches) {
  for (const auto& [end, far] : reaches)
    if ((p - end->centre).norm() < far)
      return end;
  return nullptr;
}

// Distance between a ball's surface and p, in radii of the ball.
double gap(const Vec3& p, const Balls& balls, std::size_t i) {
  return std::abs((balls.centre[i] - p).norm() - balls.radius[i]) / balls.radius[i];
}

// Index of the largest ball whose surface is within `near` of p, in radii of the ball. Neighbours must lead on from
// this ball into a vessel. If there is none, the number of balls is returned, which is no valid index.
std::size_t largest_ball_at(const Vec3& p, const Balls& balls, double near) {
  std::vector<std::size_t> touching;
  for (std::size_t i = 0; i < balls.centre.size(); ++i)
    if (gap(p, balls, i) < near)
      touching.push_back(i);
  std::stable_sort(touching.begin(), touching.end(),
                   [&](std::size_t a, std::size_t b) { return balls.radius[a] > balls.radius[b]; });
  std::vector<bool> seen(balls.centre.size(), false);
  for (std::size_t i : touching)
    if (leads_away(balls, i, p, beyond_tip * balls.radius[i], seen))
      return i;
  return balls.centre.size();
}

// The balls whose surface is less than one of their own radii from p, the nearest first.
std::vector<std::size_t> nearest_balls(const Vec3& p, const Balls& balls) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < balls.centre.size(); ++i)
    if (gap(p, balls, i) < still_at_tip)
      found.push_back(i);
  std::stable_sort(found.begin(), found.end(),
                   [&](std::size_t a, std::size_t b) { return gap(p, balls, a) < gap(p, balls, b); });
  return found;
}

// The last inscribed ball of the vessel that ends at the tip: the largest ball that touches the tip and from which
// neighbouring balls lead into the vessel. At a corner of a flat end's rim no ball touches the tip. On a rough wall the
// touching balls may have no neighbours. Then it is the largest of the balls whose surfaces come nearest to the tip. If
// no ball leads on there is no vessel, as in a sphere, and the nearest ball is returned.
std::size_t last_ball(const Mesh& mesh, const Balls& balls, Vertex tip) {
  const Vec3 p = vec(mesh.point(tip));
  if (const std::size_t touching = largest_ball_at(p, balls, 1e-6); touching < balls.centre.size())
    return touching;
  const std::vector<std::size_t> nearest = nearest_balls(p, balls);
  if (nearest.empty())
    throw InputError(
        "no axis found at a rounded end", place(p), "no inscribed ball",
        "cut the end flat, or leave it open; if it is open with a lip, cut the vessel behind the lip by --cut");
  std::vector<bool> seen(balls.centre.size(), false);
  for (std::size_t i : nearest)
    if (leads_away(balls, i, p, beyond_tip * balls.radius[i], seen)) {
      // A larger ball is used only if it leads away from the tip, too. If its search fails after visiting ball i, no
      // ball is returned, and i is used.
      const std::size_t largest = largest_ball_at(p, balls, gap(p, balls, i) + about_as_near);
      return largest < balls.centre.size() ? largest : i;
    }
  return nearest.front();
}

// The inscribed ball at a tip: the end's ball if an end lies there, else the last ball of the vessel.
std::size_t ball_of(const Mesh& mesh, const Balls& balls, const std::vector<EndReach>& reaches, Vertex tip) {
  const End* end = end_at(vec(mesh.point(tip)), reaches);
  return end ? ball_at(balls, *end) : last_ball(mesh, balls, tip);
}

Plane plane_across(const Mesh& mesh, const BallWay& way, double where) {
  return {way.centre(where), direction_of(mesh, way, where), way.radius[way.at(where)]};
}

// The first plane across the vessel with a section like the section half a radius further in. It is at least half a
// radius behind the last ball, and its cutting square covers the section. If no plane fits, the last one tried before
// the middle of the path is returned, or the middle if none was tried.
Plane cut_plane(const Mesh& mesh, const Slices& slices, const BallWay& way) {
  Plane plane = plane_across(mesh, way, 0.5 * way.length());
  for (double where = behind_last_ball * way.radius.front(); where < 0.5 * way.length();
       where += next_plane * way.radius[way.at(where)]) {
    const double ball = way.radius[way.at(where)];
    if (way.radius[way.at(where + ball)] > still_widening * ball)
      continue;
    plane = plane_across(mesh, way, where);
    const Outline here = slices.outline({plane.centre, plane.normal});
    Plane further = plane;
    further.centre += behind_last_ball * std::sqrt(here.area / M_PI) * plane.normal;
    const double area = slices.outline({further.centre, further.normal}).area;
    if (here.area > 0 && area > here.area / like_section && area < here.area * like_section) {
      plane.radius = std::max(plane.radius, section_cover * here.reach / half_width);
      return plane;
    }
  }
  return plane;
}

// A copy of the surface with no wall edge longer than `longest` (mm). Where vessels meet on a coarse surface, a vertex
// normal fits none of the vessels, and the inscribed balls of such vertices are not neighbours. More vertices connect
// the balls. The mesh's vertices keep their numbers.
Mesh sampled(const Mesh& mesh, double longest) {
  Mesh out = mesh;
  const RegionMap region = region_map(out);
  std::vector<Edge> wall;
  for (Edge e : out.edges())
    if (region[out.face(out.halfedge(e, 0))] == 0 && region[out.face(out.halfedge(e, 1))] == 0)
      wall.push_back(e);
  PMP::split_long_edges(wall, longest, out);
  return out;
}

// The tips by the distance from one extremity of the surface and from the other (tips_of), the most prominent first.
// `prominence` is in mm. Both distances are needed: a branch that leans towards an extremity hardly stands out in the
// distance from it. Of two tips closer than `apart` (mm) the less prominent one is dropped.
std::vector<Tip> tips_from_both(const Mesh& mesh, double prominence, double apart) {
  std::vector<Tip> all = tips_of(mesh, prominence), tips;
  const std::vector<Tip> from_far_end = tips_of(mesh, prominence, true);
  all.insert(all.end(), from_far_end.begin(), from_far_end.end());
  std::stable_sort(all.begin(), all.end(), [](const Tip& a, const Tip& b) { return a.prominence > b.prominence; });
  for (const Tip& tip : all) {
    const Vec3 at = vec(mesh.point(tip.vertex));
    if (std::none_of(tips.begin(), tips.end(),
                     [&](const Tip& kept) { return (vec(mesh.point(kept.vertex)) - at).norm() < apart; }))
      tips.push_back(tip);
  }
  return tips;
}

// Whether the planes of two tips make about the same cut.
bool cut_alike(const Plane& a, const Plane& b) {
  return (a.centre - b.centre).norm() < same_cut * std::max(a.radius, b.radius) && a.normal.dot(b.normal) > 0;
}

// The inscribed balls of a surface, and the index of each tip's ball.
struct TipBalls {
  Balls balls;
  std::vector<std::size_t> at;
};

// Whether chains of neighbouring balls connect the first tip's ball with the ball of every other tip.
bool hang_together(const TipBalls& tips) {
  const Ways ways = cheapest_ways(tips.balls, tips.at.front());
  return std::all_of(tips.at.begin(), tips.at.end(), [&](std::size_t ball) { return ways.cost[ball] < unreached; });
}

// The inscribed balls of the surface and each tip's ball. The wall's edges are split more finely until the balls
// connect all tips, or down to finest_edge.
TipBalls balls_of_tips(const Mesh& mesh, const std::vector<End>& ends, const std::vector<EndReach>& reaches,
                       const std::vector<Tip>& tips) {
  for (double longest = longest_edge;; longest /= 2) {
    TipBalls found{inner_balls(sampled(mesh, longest * mean_radius(mesh)), ends), {}};
    for (const Tip& tip : tips)
      found.at.push_back(ball_of(mesh, found.balls, reaches, tip.vertex));
    if (longest < 2 * finest_edge || hang_together(found))
      return found;
  }
}

} // namespace

std::vector<RoundedEnd> rounded_ends(const Mesh& mesh, const std::vector<End>& ends, double prominence,
                                     bool from_both) {
  const double mean = mean_radius(mesh);
  const std::vector<Tip> tips =
      from_both ? tips_from_both(mesh, prominence * mean, mean) : tips_of(mesh, prominence * mean);
  const std::vector<EndReach> reaches = reaches_of(mesh, ends);
  const auto is_rounded = [&](const Tip& tip) { return !end_at(vec(mesh.point(tip.vertex)), reaches); };
  if (tips.size() < 2 || std::none_of(tips.begin(), tips.end(), is_rounded))
    return {};
  const TipBalls found = balls_of_tips(mesh, ends, reaches, tips);
  const Slices slices(mesh);
  std::vector<RoundedEnd> rounded;
  for (std::size_t t = 0; t < tips.size(); ++t) {
    const Tip& tip = tips[t];
    if (!is_rounded(tip))
      continue;
    const BallWay way(found.balls, cheapest_ways(found.balls, found.at[t == 0 ? 1 : 0]), found.at[t]);
    RoundedEnd end{tip.vertex,
                   vec(mesh.point(tip.vertex)),
                   cut_plane(mesh, slices, way),
                   way.radius.front(),
                   *std::max_element(way.radius.begin(),
                                     way.radius.begin() + static_cast<std::ptrdiff_t>(way.at(tip.prominence / 2)) + 1),
                   tip.prominence,
                   way.points.size() > 1,
                   ""};
    char why[160] = "";
    if (way.length() < way.radius.front()) // a surface like a sphere has tips but no vessel between them
      std::snprintf(why, sizeof why, "its axis is %.2f mm long, less than its radius", way.length());
    else if (tip.prominence < std::max(least_prominence * mean, least_own * way.radius.front()))
      std::snprintf(why, sizeof why, "it stands out by %.2f mm only: a stub", tip.prominence);
    end.why_short = why;
    if (std::none_of(rounded.begin(), rounded.end(),
                     [&](const RoundedEnd& before) { return cut_alike(before.plane, end.plane); }))
      rounded.push_back(end);
  }
  return rounded;
}

std::vector<Tip> tips_beside_ends(const Mesh& mesh, const std::vector<End>& ends, double prominence) {
  std::vector<Tip> tips = tips_from_both(mesh, prominence, mean_radius(mesh));
  const std::vector<EndReach> reaches = reaches_of(mesh, ends);
  std::erase_if(tips, [&](const Tip& tip) { return end_at(vec(mesh.point(tip.vertex)), reaches) != nullptr; });
  return tips;
}

void cut_rounded(Mesh& mesh, const RoundedEnd& end, std::vector<Repair>& repairs) {
  const double along = end.plane.normal.dot(end.plane.centre - end.at);
  report_cut(repairs, "rounded end cut flat", end.plane,
             cut(mesh, end.plane, end.tip, "cut the end flat or leave it open, or cut the vessel there by --cut"));
  char more[48];
  std::snprintf(more, sizeof more, ", %.1f mm of the vessel", along);
  repairs.back().detail += more;
  repairs.back().warning = along > much_lost;
}

void cut_across(Mesh& mesh, const Mesh& tagged, const std::vector<End>& ends, const std::vector<Vec3>& points,
                std::vector<Repair>& repairs) {
  const std::vector<Tip> tips = tips_of(tagged, least_prominence * mean_radius(tagged));
  const Balls balls = inner_balls(tagged, ends);
  const std::vector<EndReach> reaches = reaches_of(tagged, ends);
  std::vector<BallWay> ways;
  if (tips.size() >= 2) {
    const Ways from_tip = cheapest_ways(balls, ball_of(tagged, balls, reaches, tips[0].vertex));
    for (std::size_t t = 1; t < tips.size(); ++t)
      ways.emplace_back(balls, from_tip, ball_of(tagged, balls, reaches, tips[t].vertex));
  }
  for (const Vec3& p : points) {
    const BallWay* nearest = nullptr;
    std::size_t at = 0;
    double least = 1e300;
    for (const BallWay& way : ways)
      for (std::size_t i = 0; i < way.points.size(); ++i)
        if ((way.points[i] - p).norm() < least) {
          least = (way.points[i] - p).norm();
          nearest = &way;
          at = i;
        }
    if (!nearest || least > naming_reach * nearest->radius[at])
      throw InputError("no vessel near the point to cut at", "--cut", place(p), "give a point on the vessel's axis");
    const Plane plane = plane_across(tagged, *nearest, nearest->s[at]);
    report_cut(repairs, "vessel cut across", plane,
               cut(mesh, plane, Mesh::null_vertex(), "give a point where the vessel is round and alone"));
  }
  mesh.collect_garbage();
}

} // namespace anatomy
