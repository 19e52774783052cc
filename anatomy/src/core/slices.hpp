// Cuts a surface by planes and measures the sections.
#pragma once
#include "core/types.hpp"
#include <CGAL/AABB_halfedge_graph_segment_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Polygon_mesh_slicer.h>

namespace anatomy {

using Vec2 = Eigen::Vector2d;

/// A plane with coordinates (mm) along its unit vectors u and v.
struct PlaneFrame {
  Vec3 origin, normal, u, v;
  PlaneFrame(const Vec3& o, const Vec3& n) : origin(o), normal(n), u(n.unitOrthogonal()), v(n.cross(u)) {}
  /// Coordinates of p, projected on the plane.
  Vec2 plane(const Vec3& p) const { return {(p - origin).dot(u), (p - origin).dot(v)}; }
};

/// Area (mm2) within a closed loop of points in mm; positive if the loop runs anticlockwise.
double signed_area(const std::vector<Vec2>& loop);

/// The least extent (mm) of some points over all directions in their plane: the distance of the nearest two parallel
/// lines that hold the points between them. Directions are 2.5 degrees apart, so a square is up to 2.2 % too wide. It
/// is 0 without points.
double least_extent(const std::vector<Vec2>& points);

/// The size of a section. All are 0 if no loop surrounds the origin.
struct SectionSize {
  double area = 0;  ///< mm2
  double reach = 0; ///< mm, distance from the frame's origin to the farthest point
  double width = 0; ///< mm, least extent over all directions in the plane
};

/// The area (mm2) of a section of this width (mm) and of the shape of section a. The shape of a ragged section, which
/// fills less of its width than a circle does, counts as a circle.
double area_if_alike(const SectionSize& a, double width);

/// By how many times section b is larger than section a. Its area counts, but no more of it than a section of the shape
/// of a has with the width of b. So an oblique cut, as behind an end of a bent vessel, does not count as larger.
double growth(const SectionSize& a, const SectionSize& b);

/// Cuts a mesh by planes. The mesh must outlive this object.
class Slices {
public:
  explicit Slices(const Mesh& mesh);
  /// The closed loop in which the frame's plane cuts the mesh round the frame's origin, as points in space (mm). Of
  /// several such loops it is the one of the smallest area. It is empty if there is none.
  std::vector<Vec3> loop_around(const PlaneFrame& frame) const;
  /// Size of the loop that loop_around returns.
  SectionSize section_size(const PlaneFrame& frame) const;

private:
  using EdgePrimitive = CGAL::AABB_halfedge_graph_segment_primitive<Mesh>;
  using EdgeTree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, EdgePrimitive>>;
  EdgeTree tree_;
  CGAL::Polygon_mesh_slicer<Mesh, Kernel> slicer_;
};

} // namespace anatomy
