// Plane sections of a surface.
#pragma once
#include "core/types.hpp"
#include <CGAL/AABB_halfedge_graph_segment_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Polygon_mesh_slicer.h>

namespace anatomy {

using Vec2 = Eigen::Vector2d;

/// Coordinates in a plane.
struct PlaneFrame {
  Vec3 origin, normal, u, v;
  PlaneFrame(const Vec3& o, const Vec3& n) : origin(o), normal(n), u(n.unitOrthogonal()), v(n.cross(u)) {}
  Vec2 plane(const Vec3& p) const { return {(p - origin).dot(u), (p - origin).dot(v)}; }
};

/// Area (mm2) within a closed loop; positive if it runs anticlockwise.
double signed_area(const std::vector<Vec2>& loop);

/// Area (mm2) of a section, and its farthest distance from the frame's origin (mm); area 0 if no loop surrounds it.
struct Outline {
  double area = 0, reach = 0;
};

/// Sections of a mesh, which must outlive this object.
class Slices {
public:
  explicit Slices(const Mesh& mesh);
  /// The innermost closed loop round the frame's origin, as points in space; empty if there is none.
  std::vector<Vec3> loop_around(const PlaneFrame& frame) const;
  /// Area and reach of this loop.
  Outline outline(const PlaneFrame& frame) const;

private:
  using EdgePrimitive = CGAL::AABB_halfedge_graph_segment_primitive<Mesh>;
  using EdgeTree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, EdgePrimitive>>;
  EdgeTree tree_;
  CGAL::Polygon_mesh_slicer<Mesh, Kernel> slicer_;
};

} // namespace anatomy
