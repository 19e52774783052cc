#include "ragged_ends.hpp"
#include "common/error.hpp"
#include "ends.hpp"
#include "fill_hole.hpp"
#include <CGAL/Polygon_mesh_processing/repair.h>
#include <CGAL/boost/graph/Euler_operations.h>
#include <algorithm>
#include <optional>
#include <set>

namespace anatomy {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using common::InputError;

constexpr double largest_move = 0.25;  // radii: a rim farther from its plane is not flat, however fine its triangles
constexpr double largest_loss = 1;     // radii of the vessel
constexpr double flat = 0.05;          // edges: no farther from its plane, a rim is as flat as a file can say
constexpr double crushed = 0.2;        // of a triangle's area left to it, on its own side
constexpr double behind_notch = 0.5;   // edges
constexpr double same_cap = 0.02;      // of a cap's area
constexpr double off_cap = 0.25;       // edges
constexpr double before_rim = 0.5;     // radii, of the fan's apex
constexpr double like_rim = 0.25;      // of the area within a rim that is a sawtooth
constexpr double same_section = 0.05;  // of the area
constexpr double aside_of_axis = 0.05; // radii
constexpr int most_attempts = 6;       // cuts, each an edge farther in
constexpr const char* remedy = "cut the end by a plane across the vessel";
constexpr double diagonal = 0.8; // of the cutting square's half width: what surely lies on it

// The rim as seen from its plane.
struct Rim {
  std::set<Vertex> corners;
  double spacing = 0;               // mean length of the edges at the corners, mm
  Vec3 inward = Vec3::Zero();       // the loop's normal, towards the vessel
  double deepest = 0, foremost = 0; // heights along `inward` over the loop's centre, mm
  Vec3 foremost_at = Vec3::Zero();
  double reach = 0; // farthest corner from the centre, mm

  double farthest() const { return std::max(deepest, -foremost); }
};

Rim rim_of(const Mesh& mesh, const Loop& loop) {
  Rim rim;
  double along = 0;
  std::size_t edges = 0;
  for (Halfedge h : CGAL::halfedges_around_face(loop.halfedge, mesh)) {
    const Vec3 a = vec(mesh.point(mesh.source(h))), b = vec(mesh.point(mesh.target(h)));
    along += loop.normal.dot(Vec3(vec(mesh.point(mesh.target(mesh.next(mesh.opposite(h))))) - 0.5 * (a + b)));
    rim.corners.insert(mesh.target(h));
    for (Vertex w : mesh.vertices_around_target(h)) {
      rim.spacing += (vec(mesh.point(w)) - b).norm();
      ++edges;
    }
  }
  rim.spacing /= static_cast<double>(edges);
  rim.inward = along > 0 ? loop.normal : Vec3(-loop.normal);
  rim.deepest = -1e300;
  rim.foremost = 1e300;
  for (Vertex v : rim.corners) {
    const Vec3 p = vec(mesh.point(v)) - loop.centre;
    const double height = rim.inward.dot(p);
    rim.deepest = std::max(rim.deepest, height);
    rim.reach = std::max(rim.reach, p.norm());
    if (height < rim.foremost) {
      rim.foremost = height;
      rim.foremost_at = p + loop.centre;
    }
  }
  return rim;
}

// Whether a triangle beside the rim turns over or is crushed when the rim is moved onto its plane.
bool folds(const Mesh& mesh, const Loop& loop, const Rim& rim) {
  const auto moved = [&](Vertex v) {
    const Vec3 p = vec(mesh.point(v));
    return rim.corners.contains(v) ? Vec3(p - loop.normal.dot(Vec3(p - loop.centre)) * loop.normal) : p;
  };
  for (Vertex v : rim.corners)
    for (Face f : mesh.faces_around_target(mesh.halfedge(v))) {
      if (f == Mesh::null_face())
        continue;
      std::array<Vec3, 3> before, after;
      std::size_t k = 0;
      for (Vertex w : mesh.vertices_around_face(mesh.halfedge(f))) {
        before[k] = vec(mesh.point(w));
        after[k++] = moved(w);
      }
      const Vec3 normal = (before[1] - before[0]).cross(before[2] - before[0]);
      if ((after[1] - after[0]).cross(after[2] - after[0]).dot(normal) < crushed * normal.squaredNorm())
        return true;
    }
  return false;
}

// The vertex nearest to p of those that the plane parts from the vessel: repairs may have moved the rim's corners.
Vertex vertex_before(const Mesh& mesh, const Plane& plane, const Vec3& p) {
  Vertex best = Mesh::null_vertex();
  double least = 1e300;
  for (Vertex v : mesh.vertices()) {
    const Vec3 q = vec(mesh.point(v));
    if ((q - p).norm() < least && plane.normal.dot(Vec3(q - plane.centre)) < 0) {
      least = (q - p).norm();
      best = v;
    }
  }
  return best;
}

// Whether the repair of self-intersections has changed the cap that closed the end, or crumpled it.
bool is_damaged(const Mesh& mesh, const OpenEnd& end) {
  const RegionMap region = region_map(mesh);
  Vec3 total = Vec3::Zero();
  double sum = 0, off = 0;
  for (Face f : mesh.faces()) {
    if (region[f] != end.tag)
      continue;
    const Halfedge h = mesh.halfedge(f);
    const Vec3 a = vec(mesh.point(mesh.source(h))), b = vec(mesh.point(mesh.target(h))),
               c = vec(mesh.point(mesh.target(mesh.next(h))));
    const Vec3 area = 0.5 * (b - a).cross(Vec3(c - a));
    total += area;
    sum += area.norm();
    off = std::max(off, std::abs(end.plane.normal.dot(Vec3(b - end.centre))));
  }
  return std::abs(total.norm() / end.area - 1) > same_cap || sum > (1 + same_cap) * total.norm() ||
         off > off_cap * end.spacing;
}

// The mesh without an end, and the opening that this left.
struct Opened {
  Mesh mesh;
  Loop loop;
  double lost, depth; // mm2 of wall, mm of the vessel
};

// Cut so much deeper (mm) than planned; nothing where that leaves another opening than the one, or one that is not like
// the rim.
std::optional<Opened> opened(const Mesh& mesh, const OpenEnd& end, double deeper) {
  Plane plane = end.plane;
  plane.centre += deeper * plane.normal;
  Opened out{mesh, {}, 0, end.depth + deeper};
  try {
    out.lost = cut(out.mesh, plane, vertex_before(out.mesh, plane, end.foremost), remedy);
  } catch (const InputError&) {
    return std::nullopt;
  }
  out.mesh.collect_garbage();
  const std::vector<Loop> loops = boundary_loops(out.mesh);
  if (loops.size() != 1 || std::abs(loops[0].area / end.area - 1) > like_rim)
    return std::nullopt;
  out.loop = loops[0];
  return out;
}

bool alike(const Opened& a, const Opened& b, const Vec3& along) {
  const Vec3 aside = (b.loop.centre - a.loop.centre).cross(along);
  return std::abs(b.loop.area / a.loop.area - 1) < same_section &&
         aside.norm() < aside_of_axis * std::sqrt(a.loop.area / M_PI);
}

// Cuts behind the end where the next plane, an edge farther in, finds the same section: what closed the end may reach
// behind its rim, and the wall beside it may be crumpled.
Opened cut_behind(const Mesh& mesh, const OpenEnd& end) {
  std::optional<Opened> last;
  for (int attempt = 0; attempt < most_attempts; ++attempt) {
    std::optional<Opened> next = opened(mesh, end, attempt * end.spacing);
    if (last && next && alike(*last, *next, end.plane.normal))
      return *std::move(last);
    last = std::move(next);
  }
  throw InputError("an open end is too ragged to be cut flat", place(end.centre),
                   "no two like sections within " + std::to_string(end.depth + (most_attempts - 1) * end.spacing) +
                       " mm behind its rim",
                   remedy);
}

void untag(Mesh& mesh, int tag) {
  RegionMap region = region_map(mesh);
  for (Face f : mesh.faces())
    if (region[f] == tag)
      region[f] = 0;
}

} // namespace

OpenEnd open_end(const Mesh& mesh, const Loop& loop) {
  const Rim rim = rim_of(mesh, loop);
  const double radius = std::sqrt(loop.area / M_PI);
  const double behind = rim.deepest + behind_notch * rim.spacing;
  OpenEnd end;
  end.plane = {loop.centre + behind * rim.inward, rim.inward, std::max(radius, rim.reach / (diagonal * half_width))};
  end.centre = loop.centre;
  end.foremost = rim.foremost_at;
  end.area = loop.area;
  end.depth = behind - rim.foremost;
  end.spacing = rim.spacing;
  end.ragged = rim.farthest() > flat * rim.spacing &&
               (rim.farthest() > std::min(largest_move * radius, rim.spacing) || folds(mesh, loop, rim));
  if (end.ragged && end.depth > largest_loss * radius)
    throw InputError("an open end is not cut flat", place(loop.centre),
                     "rim up to " + std::to_string(rim.farthest()) + " mm from its plane, radius " +
                         std::to_string(radius) + " mm",
                     remedy);
  return end;
}

std::vector<Face> closed_as_it_is(Mesh& mesh, const Loop& loop, const OpenEnd& end) {
  const auto around = CGAL::vertices_around_face(loop.halfedge, mesh);
  if (std::set<Vertex>(around.begin(), around.end()).size() < loop.halfedges)
    return filled(mesh, loop.halfedge);
  CGAL::Euler::fill_hole(loop.halfedge, mesh);
  const Vertex apex = mesh.target(CGAL::Euler::add_center_vertex(loop.halfedge, mesh));
  const double radius = std::sqrt(end.area / M_PI);
  mesh.point(apex) = point(end.plane.centre - (end.depth + before_rim * radius) * end.plane.normal);
  const auto faces = mesh.faces_around_target(mesh.halfedge(apex));
  return {faces.begin(), faces.end()};
}

void cut_ragged(Mesh& mesh, const std::vector<OpenEnd>& ends, std::vector<Repair>& repairs) {
  PMP::remove_isolated_vertices(mesh);
  mesh.collect_garbage();
  for (const OpenEnd& end : ends) {
    if (!end.ragged && !is_damaged(mesh, end))
      continue;
    if (!end.ragged)
      untag(mesh, end.tag);
    Opened cut_off = cut_behind(mesh, end);
    mesh = std::move(cut_off.mesh);
    char detail[192];
    std::snprintf(detail, sizeof detail, "at %s: %.2f mm of the vessel and %.2f mm2 of wall dropped, %s",
                  place(end.centre).c_str(), cut_off.depth, cut_off.lost,
                  end.ragged ? "since its rim is a sawtooth" : "since the wall crosses itself at its rim");
    repairs.push_back({"ragged end cut flat", 1, detail, true});
    cap_open_ends(mesh, repairs);
  }
}

} // namespace anatomy
