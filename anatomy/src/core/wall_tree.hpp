// Distance from a point to the wall, without the caps. For a point on the axis this is the inscribed radius.
#pragma once
#include "core/types.hpp"
#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>

namespace anatomy {

using FacePrimitive = CGAL::AABB_face_graph_triangle_primitive<Mesh>;
using FaceTree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, FacePrimitive>>;

/// Finds the nearest point and face of a mesh's wall (tag 0). The mesh must outlive this object.
class WallTree {
public:
  explicit WallTree(const Mesh& mesh);
  double distance(const Vec3& p) const; ///< mm, from p to the wall
  Point nearest(const Point& p) const { return tree_.closest_point(p); }
  Face nearest_face(const Point& p) const { return tree_.closest_point_and_primitive(p).second; }

private:
  FaceTree tree_;
};

} // namespace anatomy
