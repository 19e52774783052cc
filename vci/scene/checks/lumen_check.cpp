#include "vci/scene/checks/lumen_check.hpp"
#include "common/error.hpp"
#include "vci/geometry/axis_search.hpp"
#include "vci/geometry/surface.hpp"
#include "vci/scene/checks/plausibility.hpp"
#include "vci/scene/checks/surface_check.hpp"

#include <algorithm>
#include <cmath>

namespace vci {

namespace {
using common::text;

// A point's `radius_mm` is the radius of the largest sphere inside the lumen at the point's place on the axis. So no
// wall is nearer to that place, and some wall round it is just as near. Other walls may be at any distance, as in the
// slit of a compressed artery (1.2 x 5.0 mm). The ratio of a wall's distance to the radius must lie between two limits.
// Observed ratios are at least 0.73 in the cohort, the benchmarks and the lumens of the anatomy's tests, and 0.49 in
// the shoulder of a generated tube. They are at most 2.31 for whole lumens. A wrong unit would give 10. Distances
// within `radius_tolerance` (mm) of the radius are accepted too, since at small radii the centreline's error matters.
constexpr double least_radius_ratio = 0.4, largest_radius_ratio = 3.0, radius_tolerance = 0.2;
// mm: the axis is divided into stretches of this length. The wall nearest to a place is sought in the place's stretch
// and in the two stretches beside it.
constexpr double stretch_length = 1.0;
// Longest edge allowed: `edge_radius_ratio` times the lumen's radius plus `edge_allowance` (mm). In the lumens named
// above edges are at most 1.5 times the radius.
constexpr double edge_radius_ratio = 3.0, edge_allowance = 1.0;
constexpr double end_tolerance = 0.5; // mm by which a device or segment may reach past the lumen's end

/// Whether a wall point is far enough from the axis for its radius (both mm).
bool is_far_enough(double distance, double radius) {
  return distance > least_radius_ratio * radius || std::abs(distance - radius) < radius_tolerance;
}

/// Whether a wall point is near enough to the axis for its radius (both mm).
bool is_near_enough(double distance, double radius) {
  return distance < largest_radius_ratio * radius || distance < radius + radius_tolerance;
}

/// 0 if distance and radius (mm) fit each other, else the absolute value of the logarithm of their ratio.
double radius_misfit(double distance, double radius) {
  return is_far_enough(distance, radius) && is_near_enough(distance, radius)
             ? 0
             : std::abs(std::log((distance + 1e-12) / radius));
}

/// The place of a wall point on the branch whose distance fits the point's radius best.
struct WallPoint {
  std::size_t branch; ///< number of the branch
  Vec3 offset;        ///< vector from the nearest place on the axis to the point, mm
  double s;           ///< arc length of that place, mm
};

/// The least distance (mm) of wall points from their branch's axis, for each stretch of the axis (`stretch_length`).
class NearestWall {
public:
  explicit NearestWall(const std::map<int, WallPoint>& wall) {
    for (const auto& [v, point] : wall) {
      const auto [entry, first] = least_.try_emplace({point.branch, stretch_index(point.s)}, point.offset.norm());
      if (!first)
        entry->second = std::min(entry->second, point.offset.norm());
    }
  }
  /// The least distance (mm) in a point's stretch and in the two stretches beside it.
  double least_distance_near(const WallPoint& point) const {
    double least = point.offset.norm();
    for (int k : {-1, 0, 1})
      if (const auto entry = least_.find({point.branch, stretch_index(point.s) + k}); entry != least_.end())
        least = std::min(least, entry->second);
    return least;
  }

private:
  static int stretch_index(double s) { return static_cast<int>(std::floor(s / stretch_length)); }
  std::map<std::pair<std::size_t, int>, double> least_;
};

/// Assigns each point of the wall (by its number) to the branch whose distance fits the point's radius best.
std::map<int, WallPoint> assign_to_branches(const Lumen& lumen, const std::map<std::string, Path>& paths) {
  std::vector<AxisSearch> axes;
  for (const auto& [name, path] : paths)
    axes.emplace_back(path);
  std::vector<char> wall(lumen.points.size(), 0);
  for (std::size_t k = 0; k < lumen.triangles.size(); ++k)
    if (lumen.region[k] == 0)
      for (int v : lumen.triangles[k])
        wall[v] = 1;
  std::map<int, WallPoint> found;
  std::size_t likely_branch = 0; // the last point's branch, tried first: consecutive points mostly belong to one branch
  for (std::size_t v = 0; v < lumen.points.size(); ++v) {
    double least = wall[v] ? 1e300 : 0;
    for (std::size_t k = 0; k < axes.size() && least > 0; ++k) {
      const std::size_t a = (likely_branch + k) % axes.size();
      const AxisPoint place = axes[a].nearest(lumen.points[v]);
      const Vec3 offset = lumen.points[v] - place.point;
      if (const double own = radius_misfit(offset.norm(), lumen.radius[v]); own < least) {
        least = own;
        found[static_cast<int>(v)] = {a, offset, place.s};
      }
    }
    if (wall[v] && least == 0)
      likely_branch = found.at(static_cast<int>(v)).branch;
  }
  return found;
}

/// For each point of the lumen the vector (mm) to it from the axis of its branch; 0 for points of caps. Throws
/// common::InputError if a distance does not fit the point's radius.
Vectors offsets_from_axis(const Lumen& lumen, const std::map<std::string, Path>& paths, const std::string& file) {
  const std::map<int, WallPoint> wall = assign_to_branches(lumen, paths);
  const NearestWall nearest(wall);
  Vectors offsets(lumen.points.size(), Vec3::Zero());
  double worst = 0, distance = 0;
  int misfits = 0, where = -1;
  for (const auto& [v, point] : wall) {
    offsets[v] = point.offset;
    const double r = lumen.radius[v], own = point.offset.norm();
    // radius_mm is the radius of the largest sphere inside, so only the nearest wall has to lie at this distance. If a
    // point is far enough from the axis, the nearest wall round its place decides whether the wall is too far away.
    const double judged = is_far_enough(own, r) ? nearest.least_distance_near(point) : own;
    const double log_ratio =
        is_far_enough(own, r) && is_near_enough(judged, r) ? 0 : std::abs(std::log((judged + 1e-12) / r));
    misfits += log_ratio > 0;
    if (log_ratio > worst) {
      worst = log_ratio;
      distance = judged;
      where = v;
    }
  }
  if (where >= 0)
    throw common::InputError(
        "the lumen's wall does not fit its radius_mm and the centreline", point_location(lumen, where, file),
        text("the wall is ", distance, " mm from the branch's axis there, radius_mm ", lumen.radius[where], "; ",
             misfits, " of ", lumen.points.size(), " points do not fit"),
        text("give lumen and centreline of one vessel in mm, with radius_mm the radius of the "
             "largest sphere inside: the nearest wall lies at ",
             least_radius_ratio, " to ", largest_radius_ratio, " times it from the axis"));
  return offsets;
}

void refuse_long_edges(const Lumen& lumen, const std::string& file) {
  for (std::size_t k = 0; k < lumen.triangles.size(); ++k) {
    if (lumen.region[k] != 0)
      continue;
    for (int c = 0; c < 3; ++c) {
      const int a = lumen.triangles[k][c], b = lumen.triangles[k][(c + 1) % 3];
      const double length = (lumen.points[b] - lumen.points[a]).norm();
      const double limit = edge_radius_ratio * std::max(lumen.radius[a], lumen.radius[b]) + edge_allowance;
      if (length > limit)
        throw common::InputError("a triangle of the lumen is far longer than the lumen is wide",
                                 triangle_location(lumen, k, file),
                                 text(length, " mm between points ", a, " and ", b, "; at most ", limit),
                                 "put the misplaced point right, or remesh the lumen with the anatomy step");
    }
  }
}

void refuse_inward(const Lumen& lumen, const Vectors& offsets, const std::string& file) {
  double flux = 0;
  std::size_t inward = 0, wall = 0, first = 0;
  for (std::size_t k = 0; k < lumen.triangles.size(); ++k) {
    if (lumen.region[k] != 0)
      continue;
    const Triangle& t = lumen.triangles[k];
    const double own = area_vector(t, lumen.points).dot(offsets[t[0]] + offsets[t[1]] + offsets[t[2]]) / 3;
    flux += own;
    ++wall;
    if (own < 0 && inward++ == 0)
      first = k;
  }
  if (wall == 0)
    throw common::InputError("the lumen has no wall", file, "no triangle with region_id 0",
                             "write region_id 0 for the wall's triangles, other numbers for caps");
  if (!(flux > 0))
    throw common::InputError("the lumen's triangles face its axis", triangle_location(lumen, first, file),
                             text(inward, " of ", wall, " triangles of the wall face inward"),
                             "turn all triangles: seen from outside the vessel their points run counterclockwise");
}

/// Arc length (mm) at which a branch's axis passes through an open end of the wall, bounded by `rim`. The axis is
/// extended straight beyond its ends. Nothing if the axis passes beside the rim.
std::optional<double> passing_arc_length(const Path& path, const Rim& rim, const Lumen& lumen) {
  Vec3 centre = Vec3::Zero();
  for (int v : rim)
    centre += lumen.points[v] / static_cast<double>(rim.size());
  double reach = 0;
  for (int v : rim)
    reach = std::max(reach, (lumen.points[v] - centre).norm());
  Vectors points{path.at(path.start() - 4 * reach)};
  points.insert(points.end(), path.points().begin(), path.points().end());
  points.push_back(path.at(path.end() + 4 * reach));
  double s = path.start() - 4 * reach, passing = s, distance = 1e300;
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    const Vec3 along = points[k + 1] - points[k];
    const double length = along.norm(), t = std::clamp((centre - points[k]).dot(along) / length, 0.0, length);
    if (const double d = (points[k] + t / length * along - centre).norm(); d < distance) {
      distance = d;
      passing = s + t;
    }
    s += length;
  }
  // The rim surrounds the axis if it turns round it by more than half a turn in all.
  const Vec3 origin = path.at(passing), axis = path.tangent(passing), first = axis.unitOrthogonal();
  const Vec3 second = axis.cross(first);
  double turn = 0;
  for (std::size_t k = 0; k < rim.size(); ++k) {
    const Vec3 a = lumen.points[rim[k]] - origin, b = lumen.points[rim[(k + 1) % rim.size()]] - origin;
    const Eigen::Vector2d p(a.dot(first), a.dot(second)), q(b.dot(first), b.dot(second));
    turn += std::atan2(p[0] * q[1] - p[1] * q[0], p.dot(q));
  }
  return std::abs(turn) > pi ? std::optional(passing) : std::nullopt;
}

struct Extent {
  double start, end; ///< arc lengths where a branch's axis enters and leaves the lumen, mm
};

/// The extent of each branch within the lumen. Throws common::InputError unless each branch's axis passes through two
/// open ends of the wall, and each open end belongs to a branch.
std::map<std::string, Extent> branch_extents(const Lumen& lumen, const std::vector<Rim>& rims,
                                             const std::map<std::string, Path>& paths, const std::string& file) {
  std::map<std::string, Extent> extents;
  std::vector<char> on_branch(rims.size(), 0);
  for (const auto& [name, path] : paths) {
    std::vector<double> places;
    for (std::size_t r = 0; r < rims.size(); ++r)
      if (const auto s = passing_arc_length(path, rims[r], lumen)) {
        places.push_back(*s);
        on_branch[r] = 1;
      }
    std::sort(places.begin(), places.end());
    if (places.size() != 2) {
      std::string at;
      for (double s : places)
        at += text(at.empty() ? " at s = " : ", ", s, " mm");
      throw common::InputError("the lumen's ends are not those of the centreline", file + ": branch " + name,
                               text("its axis passes through ", places.size(), " ends of the wall", at),
                               "a branch has two, the inlet and its own: give the centreline of this lumen, whose wall "
                               "is whole between them and whose caps have a region_id other than 0");
    }
    extents[name] = {places.front(), places.back()};
  }
  for (std::size_t r = 0; r < rims.size(); ++r)
    if (!on_branch[r])
      throw common::InputError("the lumen's wall has a hole", point_location(lumen, rims[r].front(), file),
                               text("an open rim of ", rims[r].size(), " edges that no branch's axis passes through"),
                               "close it, or add the branch that ends there to the centreline");
  return extents;
}

/// Refuses a main branch that does not start at the inlet: devices would be placed by arc lengths from the wrong end.
/// The inlet's cap is known by its region_id, which the anatomy step sets. A lumen without this mark is not checked.
void refuse_reversed_main(const Lumen& lumen, const std::map<std::string, Path>& paths, const std::string& file) {
  constexpr int inlet = 1; // region_id
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (std::size_t k = 0; k < lumen.triangles.size(); ++k)
    if (lumen.region[k] == inlet)
      for (int v : lumen.triangles[k]) {
        sum += lumen.points[v];
        ++count;
      }
  if (count == 0)
    return;
  const Vectors& axis = paths.at("main").points();
  const double start = (axis.front() - sum / count).norm(), end = (axis.back() - sum / count).norm();
  if (end < start)
    throw common::InputError("the centreline's main branch does not start at the inlet", file + ": branch main",
                             text("its start is ", start, " mm from the cap with region_id 1, its end ", end),
                             "turn the branch round: it runs from the inlet to an outlet");
}

void refuse_span_past_lumen(const Extent& e, double start, double end, const std::string& what,
                            const std::string& where) {
  if (start < e.start - end_tolerance || end > e.end + end_tolerance)
    throw common::InputError(what + " reaches past the end of the lumen", where,
                             text("from ", start, " to ", end, " mm"),
                             text("place it within ", e.start, " to ", e.end, " mm, or give more of the lumen"));
}

void refuse_devices_past_lumen(const Scene& scene, const std::map<std::string, Extent>& extents) {
  for (std::size_t step = 0; step < scene.procedure.size(); ++step)
    for (std::size_t device = 0; device < scene.procedure[step].devices.size(); ++device) {
      const Placement& p = scene.procedure[step].devices[device];
      const double half = 0.5 * scene.opened_length(p.device);
      refuse_span_past_lumen(extents.at(p.branch), p.centre_s - half, p.centre_s + half, "a device",
                             device_location(scene, step, device));
    }
  if (scene.segment)
    refuse_span_past_lumen(extents.at(scene.segment->branch), scene.segment->s_start, scene.segment->s_end,
                           "the segment", scene.file.string() + ": scene.segment");
}

} // namespace

void check_lumen(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& paths) {
  const std::string file = scene.lumen.string();
  const std::vector<Rim> rims = checked_rims(lumen, file);
  const Vectors offsets = offsets_from_axis(lumen, paths, file);
  refuse_long_edges(lumen, file);
  refuse_inward(lumen, offsets, file);
  refuse_reversed_main(lumen, paths, scene.centreline.string());
  refuse_devices_past_lumen(scene, branch_extents(lumen, rims, paths, file));
}

} // namespace vci
