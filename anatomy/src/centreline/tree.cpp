#include "centreline/tree.hpp"
#include "common/error.hpp"
#include <algorithm>
#include <numeric>

namespace anatomy {
namespace {

constexpr double bin_length = 0.25; // mm of path over which the points of a Voronoi path are averaged
// The path nearer to an end's cap than this (in radii of the end) is left out. Few spheres are left there to average.
constexpr double end_trim_radii = 0.5;
// Least distance of an end's centre outside the parent's inscribed tube, in radii of the end. A flat facet of the
// parent's wall lies nearer.
constexpr double least_stub = 0.3;
constexpr double look_ahead = 1.5; // the direction of a side branch is taken over this many parent radii from its exit

double arc_length(const std::vector<Vec3>& points) {
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i)
    length += (points[i] - points[i - 1]).norm();
  return length;
}

// The mean points of a path in bins of equal arc length, weighted by the length of path at each point.
std::vector<Vec3> binned(const std::vector<Vec3>& points) {
  std::vector<Vec3> out;
  Vec3 sum = Vec3::Zero();
  double weight = 0, s = 0, bin_end = bin_length;
  const auto close_bin = [&] {
    if (weight > 0)
      out.push_back(sum / weight);
    sum.setZero();
    weight = 0;
  };
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const double w = (points[i + 1] - points[i]).norm();
    // A long step of the path is shared among the bins that it crosses.
    const int pieces = std::max(1, static_cast<int>(std::ceil(w / (0.2 * bin_length))));
    for (int k = 0; k < pieces; ++k) {
      const double f = (k + 0.5) / pieces;
      const double here = s + f * w;
      while (here > bin_end) {
        close_bin();
        bin_end += bin_length;
      }
      sum += w / pieces * ((1 - f) * points[i] + f * points[i + 1]);
      weight += w / pieces;
    }
    s += w;
  }
  close_bin();
  return out;
}

// Index of the branch's sample nearest to p.
std::size_t nearest_sample(const Branch& branch, const Vec3& p) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < branch.x.size(); ++i)
    if ((branch.x[i] - p).squaredNorm() < (branch.x[best] - p).squaredNorm())
      best = i;
  return best;
}

bool inside_tube(const Branch& branch, const Vec3& p) {
  const std::size_t i = nearest_sample(branch, p);
  return (branch.x[i] - p).norm() < branch.radius[i];
}

// The points of the path from index `first` on, without those too near to the caps of the ends `from` (may be null) and
// `to`.
std::vector<Vec3> between(const Path& path, std::size_t first, const End* from, const End& to) {
  std::vector<Vec3> out;
  for (std::size_t i = first; i < path.points.size(); ++i) {
    const auto near = [&](const End& end) {
      return std::abs((path.points[i] - end.centre).dot(end.normal)) < end_trim_radii * end.radius() &&
             (path.points[i] - end.centre).norm() < 2 * end.radius();
    };
    if (!(from && near(*from)) && !near(to))
      out.push_back(path.points[i]);
  }
  return out;
}

// Fills the branch's samples, about `step` mm apart.
void sample(Branch& branch, const WallTree& wall, double step) {
  const int n = std::max(4, static_cast<int>(std::lround(branch.axis.length() / step)));
  for (int i = 0; i <= n; ++i) {
    const double s = branch.axis.length() * i / n;
    branch.s.push_back(s);
    branch.x.push_back(branch.axis.at(s));
    branch.radius.push_back(wall.distance(branch.x.back()));
    branch.curvature.push_back(branch.axis.curvature(s));
    branch.torsion.push_back(branch.axis.torsion(s));
  }
}

// Index of the parent's sample where the line that continues a side branch backwards first comes nearest to the
// parent's axis. The line goes through `exit`, where the branch leaves the parent's tube, in its `direction` there. In
// a bend the line may come nearer to the axis again, but far upstream and through the wall.
std::size_t find_take_off(const Branch& parent, const Vec3& exit, const Vec3& direction) {
  std::size_t best = nearest_sample(parent, exit);
  double nearest = 1e300;
  for (std::size_t i = best + 1; i-- > 0;) {
    const Vec3 d = parent.x[i] - exit;
    const double along = std::min(0.0, d.dot(direction));
    const double distance = (d - along * direction).norm();
    if (distance >= nearest)
      break;
    nearest = distance;
    best = i;
  }
  return best;
}

// Throws InputError if the end lies in the wall of the vessel `trunk`, since no branch leads to it.
void check_stands_out(const Branch& trunk, const End& end) {
  const std::size_t i = nearest_sample(trunk, end.centre);
  const double out = (trunk.x[i] - end.centre).norm() - trunk.radius[i];
  if (out >= least_stub * end.radius())
    return;
  char value[160];
  std::snprintf(value, sizeof value, "radius %.2f mm, centre %.2f mm outside the vessel's inscribed radius of %.2f mm",
                end.radius(), out, trunk.radius[i]);
  throw common::InputError(
      "an end lies in the wall of another vessel: no branch leads to it", point_text(end.centre), value,
      "where it is a flat facet of the wall, name the ends by --inlet and --outlet; where a branch "
      "leaves, leave a stub at least " +
          std::to_string(static_cast<int>(100 * least_stub)) + " % of its radius long");
}

struct TreeBuilder {
  const std::vector<Path>& paths;
  const std::vector<End>& ends;
  const End& inlet;
  const WallTree& wall;
  double step;
  std::vector<Branch> branches;
  std::vector<double> from_inlet; // mm of path from the inlet to where each branch leaves its parent

  void add_main(std::size_t end) {
    Branch main;
    main.end = end;
    std::vector<Vec3> points = binned(between(paths[end], 0, &inlet, ends[end]));
    points.insert(points.begin(), inlet.centre);
    points.push_back(ends[end].centre);
    main.axis = Axis(points);
    sample(main, wall, step);
    branches.push_back(main);
    from_inlet.push_back(0);
  }

  void add_side_branch(std::size_t end) {
    const Path& path = paths[end];
    std::size_t parent = 0, exit = 0;
    for (std::size_t b = 0; b < branches.size(); ++b) {
      std::size_t i = path.points.size();
      while (i > 0 && !inside_tube(branches[b], path.points[i - 1]))
        --i;
      if (i > exit) {
        exit = i;
        parent = b;
      }
    }
    const Branch& trunk = branches[parent];
    check_stands_out(trunk, ends[end]);
    std::vector<Vec3> outside = between(path, exit, nullptr, ends[end]);
    // `between` leaves out the path next to a cap. If nothing is left of a short side branch, its axis is straight.
    if (outside.empty())
      outside.push_back(exit < path.points.size() ? path.points[exit] : path.points.back());
    std::size_t ahead = 0;
    const double reach = look_ahead * trunk.radius[nearest_sample(trunk, outside.front())];
    while (ahead + 1 < outside.size() && (outside[ahead] - outside.front()).norm() < reach)
      ++ahead;
    const Vec3 towards = ahead > 0 ? outside[ahead] : ends[end].centre;
    const std::size_t root = find_take_off(trunk, outside.front(), (towards - outside.front()).normalized());
    std::vector<Vec3> points = binned(outside);
    points.insert(points.begin(), trunk.x[root]);
    points.push_back(ends[end].centre);
    if (points.size() < 3) // too few for a spline
      points.insert(points.begin() + 1, 0.5 * (points.front() + points.back()));
    Branch side;
    side.end = end;
    side.parent = static_cast<int>(parent);
    side.s_on_parent = trunk.s[root];
    side.axis = Axis(points);
    sample(side, wall, step);
    for (std::size_t i = 0; i < side.x.size(); ++i)
      if (inside_tube(trunk, side.x[i]))
        side.s_outside = side.s[i];
    from_inlet.push_back(from_inlet[parent] + side.s_on_parent);
    branches.push_back(side);
  }
};

// Names the branches by their ids, and sorts them by id. The ids of an earlier state may have gaps, since a branch may
// be missing from the lumen found after a procedure.
void renumber(std::vector<Branch>& branches, const std::vector<int>& id_of) {
  for (std::size_t b = 0; b < branches.size(); ++b) {
    branches[b].id = id_of[b];
    branches[b].name = id_of[b] == 0 ? "main" : "side" + std::to_string(id_of[b]);
  }
  std::vector<int> new_index(branches.size());
  for (std::size_t b = 0; b < branches.size(); ++b)
    new_index[b] =
        static_cast<int>(std::count_if(id_of.begin(), id_of.end(), [&](int other) { return other < id_of[b]; }));
  for (Branch& branch : branches)
    if (branch.parent >= 0)
      branch.parent = new_index[static_cast<std::size_t>(branch.parent)];
  std::sort(branches.begin(), branches.end(), [](const Branch& a, const Branch& b) { return a.id < b.id; });
}

} // namespace

double Branch::radius_at(double at) const {
  const double f = std::clamp(at / s.back(), 0.0, 1.0) * static_cast<double>(s.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(f), s.size() - 2);
  return radius[i] + (f - static_cast<double>(i)) * (radius[i + 1] - radius[i]);
}

std::vector<Branch> build_tree(const std::vector<Path>& paths, std::vector<End>& ends, std::size_t inlet,
                               const WallTree& wall, double step, const std::vector<int>& wanted) {
  std::vector<std::size_t> order;
  for (std::size_t e = 0; e < ends.size(); ++e)
    if (e != inlet)
      order.push_back(e);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    if (!wanted.empty() && (wanted[a] == 0 || wanted[b] == 0))
      return wanted[a] == 0 && wanted[b] != 0;
    return arc_length(paths[a].points) > arc_length(paths[b].points);
  });
  TreeBuilder builder{paths, ends, ends[inlet], wall, step, {}, {}};
  builder.add_main(order.front());
  for (std::size_t k = 1; k < order.size(); ++k)
    builder.add_side_branch(order[k]);

  std::vector<Branch> branches = std::move(builder.branches);
  std::vector<int> id_of(branches.size(), 0);
  std::vector<std::size_t> rank(branches.size());
  std::iota(rank.begin(), rank.end(), 0);
  std::stable_sort(rank.begin() + 1, rank.end(),
                   [&](std::size_t a, std::size_t b) { return builder.from_inlet[a] < builder.from_inlet[b]; });
  for (std::size_t r = 0; r < rank.size(); ++r)
    id_of[rank[r]] = wanted.empty() ? static_cast<int>(r) : wanted[branches[rank[r]].end];
  renumber(branches, id_of);

  ends[inlet].name = "inlet";
  ends[inlet].inlet = true;
  ends[inlet].branch = "main";
  ends[inlet].region = 1;
  for (const Branch& branch : branches) {
    End& end = ends[branch.end];
    end.branch = branch.name;
    end.region = 2 + branch.id;
    end.name = "outlet" + std::to_string(1 + branch.id);
  }
  return branches;
}

namespace {

// Replaces `nearest` by a sample of the branch to whose inscribed sphere p is nearer than `least`, which is then
// updated.
void search_branch(const Branch& branch, std::size_t index, const Vec3& p, NearestAxis& nearest, double& least) {
  for (std::size_t i = 0; i < branch.x.size(); ++i) {
    if (branch.s[i] < branch.s_outside)
      continue;
    const double d2 = (branch.x[i] - p).squaredNorm();
    const double power = d2 - branch.radius[i] * branch.radius[i];
    if (power < least) {
      least = power;
      nearest = {index, i, std::sqrt(d2)};
    }
  }
}

} // namespace

NearestAxis nearest_axis(const std::vector<Branch>& branches, const Vec3& p) {
  NearestAxis nearest{0, 0, 1e300};
  double least = 1e300;
  for (std::size_t b = 0; b < branches.size(); ++b)
    search_branch(branches[b], b, p, nearest, least);
  return nearest;
}

NearestAxis nearest_axis(const Branch& branch, const Vec3& p) {
  NearestAxis nearest{0, 0, 1e300};
  double least = 1e300;
  search_branch(branch, 0, p, nearest, least);
  return nearest;
}

} // namespace anatomy
