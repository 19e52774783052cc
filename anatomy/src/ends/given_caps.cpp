#include "ends/given_caps.hpp"
#include "common/error.hpp"
#include "core/faces.hpp"
#include "ends/planar_patches.hpp"
#include "repair/loops.hpp"
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/boost/graph/Euler_operations.h>
#include <algorithm>

namespace anatomy {
namespace {

using common::InputError;
using Iterator = std::vector<Kernel::Triangle_3>::const_iterator;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

constexpr double on_cap = 0.02;       // radii between a face's centre and the cap that it lies on
constexpr double cos_cap = 0.9;       // 26 degrees between the face and the cap's triangle nearest to it
constexpr double same_point = 1e-5;   // radii: files store coordinates in single precision
constexpr double least_covered = 0.5; // of the cap's area, by the faces that lie on it
constexpr double at_rim = 0.5;        // radii from an end to the cap that closes it, for wall and cap of other meshes

double radius_of(double area) {
  return std::sqrt(area / M_PI);
}

// The faces that lie on the cap. A face without an area has no direction; it lies on the cap if its corners do.
std::vector<Face> faces_on(const Mesh& mesh, const Tree& cap, double radius) {
  const auto is_on_cap = [&](Face f) {
    const auto [nearest, triangle] = cap.closest_point_and_primitive(point(centroid(mesh, f)));
    if ((vec(nearest) - centroid(mesh, f)).norm() > on_cap * radius)
      return false;
    const Vec3 area = area_vector(mesh, f);
    const Vec3 a = vec(triangle->vertex(0)), b = vec(triangle->vertex(1)), c = vec(triangle->vertex(2));
    const Vec3 of_cap = (b - a).cross(Vec3(c - a));
    if (std::abs(area.dot(of_cap)) >= cos_cap * area.norm() * of_cap.norm())
      return true;
    const auto corners = mesh.vertices_around_face(mesh.halfedge(f));
    return std::all_of(corners.begin(), corners.end(),
                       [&](Vertex v) { return std::sqrt(cap.squared_distance(mesh.point(v))) < same_point * radius; });
  };
  std::vector<Face> faces;
  std::copy_if(mesh.faces().begin(), mesh.faces().end(), std::back_inserter(faces), is_on_cap);
  return faces;
}

// Centres of the ends that the cap closes: openings whose rims lie on the cap, and faces there that the surface tags.
// The rim decides, since the middle of a dome may be far from it.
std::vector<Vec3> ends_at(const Mesh& mesh, const Tree& cap, double radius) {
  const auto is_at_cap = [&](const std::vector<Vec3>& places, double area) {
    double sum = 0;
    for (const Vec3& p : places)
      sum += std::sqrt(cap.squared_distance(point(p)));
    return sum < at_rim * std::min(radius, radius_of(area)) * static_cast<double>(places.size());
  };
  std::vector<Vec3> centres;
  for (const Loop& loop : boundary_loops(mesh)) {
    std::vector<Vec3> rim;
    for (Vertex v : CGAL::vertices_around_face(loop.halfedge, mesh))
      rim.push_back(vec(mesh.point(v)));
    if (is_at_cap(rim, loop.area))
      centres.push_back(loop.centre);
  }
  for (const auto& [tag, faces] : tagged_faces(mesh)) {
    std::vector<Vec3> places;
    for (Face f : faces)
      places.push_back(centroid(mesh, f));
    if (const PatchPlane plane = plane_of(mesh, faces); is_at_cap(places, plane.area))
      centres.push_back(plane.centre);
  }
  return centres;
}

// Removes the faces on the cap.
void open_at(Mesh& mesh, const GivenCap& cap, const Tree& tree) {
  const std::vector<Face> faces = faces_on(mesh, tree, radius_of(cap.area));
  double covered = 0;
  for (Face f : faces)
    covered += area_vector(mesh, f).norm();
  if (covered < least_covered * cap.area)
    throw InputError("no end of the vessel at a given cap", cap.path,
                     "its centre " + place(cap.centre) + ", area " + std::to_string(cap.area) + " mm2",
                     "check that cap and surface are in the same frame and unit");
  for (Face f : faces)
    CGAL::Euler::remove_face(mesh.halfedge(f), mesh);
  mesh.collect_garbage();
}

} // namespace

std::vector<Vec3> open_given_caps(Mesh& mesh, const std::vector<GivenCap>& caps) {
  std::vector<Vec3> centres;
  for (const GivenCap& cap : caps) {
    std::vector<Kernel::Triangle_3> triangles;
    for (const Triangle& t : cap.triangles.triangles)
      triangles.emplace_back(cap.triangles.points[t[0]], cap.triangles.points[t[1]], cap.triangles.points[t[2]]);
    const Tree tree(triangles.begin(), triangles.end());
    std::vector<Vec3> ends = ends_at(mesh, tree, radius_of(cap.area));
    if (ends.empty()) {
      open_at(mesh, cap, tree);
      ends = ends_at(mesh, tree, radius_of(cap.area));
    }
    if (ends.size() != 1)
      throw InputError("a given cap does not close one end of the vessel", cap.path,
                       "without its faces the surface has " + std::to_string(ends.size()) + " openings there",
                       "give the triangles that close this end, and no others");
    centres.push_back(ends[0]);
  }
  return centres;
}

} // namespace anatomy
