#include "ends/open_end.hpp"
#include "common/error.hpp"
#include "repair/fill_hole.hpp"
#include <CGAL/boost/graph/Euler_operations.h>
#include <algorithm>
#include <set>

namespace anatomy {
namespace {

using common::InputError;

// A rim with a corner farther from its plane than this (in radii of the rim) is ragged, however long its edges.
constexpr double largest_move_radii = 0.25;
constexpr double largest_loss_radii = 1; // greatest length of vessel that a cut may lose, in radii of the rim
// A rim nearer to its plane than this (in edge lengths) is as flat as a file's digits can say.
constexpr double flat_tolerance = 0.05;
constexpr double least_kept_area = 0.2; // least share of its area that a triangle must keep when the rim is flattened
constexpr double notch_margin = 0.5;    // distance from the rim's deepest notch to the cutting plane, in edge lengths
constexpr double apex_radii = 0.5; // distance from the rim's outermost corner to the fan's apex, in radii of the rim
// Largest distance of the rim's corners from the centre, as a share of the cutting square's half width.
constexpr double corner_reach = 0.8;
// A rim, with the heights of its corners over its plane (`Loop::normal`).
struct Rim {
  std::set<Vertex> corners;
  double spacing = 0;                   // mm, mean length of the edges at the corners
  Vec3 inward = Vec3::Zero();           // unit normal of the plane, towards the vessel
  double deepest = 0, outermost = 0;    // mm, largest and smallest height of a corner along `inward`
  Vec3 outermost_corner = Vec3::Zero(); // mm, the corner at the height `outermost`
  double reach = 0;                     // mm, from the centre to the farthest corner

  double farthest() const { return std::max(deepest, -outermost); }
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
  rim.outermost = 1e300;
  for (Vertex v : rim.corners) {
    const Vec3 p = vec(mesh.point(v)) - loop.centre;
    const double height = rim.inward.dot(p);
    rim.deepest = std::max(rim.deepest, height);
    rim.reach = std::max(rim.reach, p.norm());
    if (height < rim.outermost) {
      rim.outermost = height;
      rim.outermost_corner = p + loop.centre;
    }
  }
  return rim;
}

// Whether a triangle beside the rim turns over or loses too much area when the rim is moved onto its plane.
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
      if ((after[1] - after[0]).cross(after[2] - after[0]).dot(normal) < least_kept_area * normal.squaredNorm())
        return true;
    }
  return false;
}

} // namespace

OpenEnd open_end(const Mesh& mesh, const Loop& loop) {
  const Rim rim = rim_of(mesh, loop);
  const double radius = std::sqrt(loop.area / pi);
  const double behind = rim.deepest + notch_margin * rim.spacing;
  OpenEnd end;
  end.plane = {loop.centre + behind * rim.inward, rim.inward,
               std::max(radius, rim.reach / (corner_reach * square_half_width))};
  end.centre = loop.centre;
  end.outermost = rim.outermost_corner;
  end.area = loop.area;
  end.depth = behind - rim.outermost;
  end.spacing = rim.spacing;
  end.ragged = rim.farthest() > flat_tolerance * rim.spacing &&
               (rim.farthest() > std::min(largest_move_radii * radius, rim.spacing) || folds(mesh, loop, rim));
  if (end.ragged && end.depth > largest_loss_radii * radius)
    throw InputError("an open end is not cut flat", point_text(loop.centre),
                     "rim up to " + std::to_string(rim.farthest()) + " mm from its plane, radius " +
                         std::to_string(radius) + " mm",
                     cut_remedy);
  return end;
}

std::vector<Face> close_unflattened(Mesh& mesh, const Loop& loop, const OpenEnd& end) {
  const auto around = CGAL::vertices_around_face(loop.halfedge, mesh);
  if (std::set<Vertex>(around.begin(), around.end()).size() < loop.halfedges)
    return fill_hole(mesh, loop.halfedge);
  CGAL::Euler::fill_hole(loop.halfedge, mesh);
  const Vertex apex = mesh.target(CGAL::Euler::add_center_vertex(loop.halfedge, mesh));
  const double radius = std::sqrt(end.area / pi);
  mesh.point(apex) = point(end.plane.centre - (end.depth + apex_radii * radius) * end.plane.normal);
  const auto faces = mesh.faces_around_target(mesh.halfedge(apex));
  return {faces.begin(), faces.end()};
}

} // namespace anatomy
