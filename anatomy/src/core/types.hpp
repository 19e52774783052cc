// Types shared by all of anatomy. Lengths in mm.
#pragma once
#include "core/cgal_versions.hpp"
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <Eigen/Dense>
#include <array>
#include <map>
#include <numbers>
#include <string>
#include <vector>

namespace anatomy {

using std::numbers::pi;

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Vector = Kernel::Vector_3;
using Mesh = CGAL::Surface_mesh<Point>;
using Face = Mesh::Face_index;
using Vertex = Mesh::Vertex_index;
using Halfedge = Mesh::Halfedge_index;
using Edge = Mesh::Edge_index;
using RegionMap = Mesh::Property_map<Face, int>;
using Vec3 = Eigen::Vector3d;
using Triangle = std::array<std::size_t, 3>;

inline Vec3 vec(const Point& p) {
  return {p.x(), p.y(), p.z()};
}
inline Point point(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

/// Triangles as read from a file. Their orientation may vary, and there may be duplicates and gaps.
struct Soup {
  std::vector<Point> points;
  std::vector<Triangle> triangles;
  std::vector<int> region; ///< tag per triangle, from the array region_id; empty if the file has none
};

/// One change of the input surface, or a remark on it, for the report to the user.
struct Repair {
  std::string what;
  std::size_t count;
  std::string detail;
  bool warning = false; ///< whether the entry is also printed as a warning, because the user may object to the change
};

/// A flat end of the lumen, closed by a cap. `region` is the tag of the cap's faces in the property map "f:region", in
/// which 0 is wall.
struct End {
  std::string name;
  int region = 0;
  bool inlet = false;
  std::string branch;
  Vec3 centre = Vec3::Zero(); ///< mm
  Vec3 normal = Vec3::Zero(); ///< unit vector that points out of the lumen
  double area = 0;            ///< mm2
  double extension = 0;       ///< length (mm) of straight wall that was added to move the end outward
  double radius() const;      ///< radius (mm) of a circle with the same area
};

inline double End::radius() const {
  return std::sqrt(area / pi);
}

/// The tag of each face: 0 is wall, any other number is a cap. If the mesh has no tags, the first function creates
/// them, with every face as wall. The second function needs a mesh with tags.
inline RegionMap region_map(Mesh& mesh) {
  return mesh.add_property_map<Face, int>("f:region", 0).first;
}
inline RegionMap region_map(const Mesh& mesh) {
  return existing_map<RegionMap>(mesh, "f:region");
}

/// The point p as text for messages: "(x, y, z) mm".
inline std::string point_text(const Vec3& p) {
  char text[96];
  std::snprintf(text, sizeof text, "(%.2f, %.2f, %.2f) mm", p.x(), p.y(), p.z());
  return text;
}

} // namespace anatomy
