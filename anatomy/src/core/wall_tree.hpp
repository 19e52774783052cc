// Distance to the wall (without caps): the inscribed radius of a point on the axis.
#pragma once
#include "core/types.hpp"
#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>

namespace anatomy {

using FacePrimitive = CGAL::AABB_face_graph_triangle_primitive<Mesh>;
using FaceTree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, FacePrimitive>>;

/// Wall faces (region 0) of a mesh, which must outlive this object.
class WallTree {
public:
  explicit WallTree(const Mesh& mesh);
  double distance(const Vec3& p) const;
  Point nearest(const Point& p) const { return tree_.closest_point(p); }
  Face nearest_face(const Point& p) const { return tree_.closest_point_and_primitive(p).second; }

private:
  FaceTree tree_;
};

} // namespace anatomy
