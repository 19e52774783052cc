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

constexpr double on_cap = 0.02;       // radii between a face's centre and the cap that it lies on
constexpr double cos_cap = 0.9;       // 26 degrees between the face and the cap's triangle nearest to it
constexpr double same_point = 1e-5;   // radii: files store coordinates in single precision
constexpr double least_covered = 0.5; // of the cap's area, by the faces that lie on it

constexpr const char* check_frame = "check that cap and surface are in the same frame and unit";

// The faces that lie on the cap. A face without an area has no direction; it lies on the cap if its corners do.
std::vector<Face> faces_on(const Mesh& mesh, const GivenCap& cap) {
  const double radius = std::sqrt(cap.area / M_PI);
  std::vector<Kernel::Triangle_3> triangles;
  for (const Triangle& t : cap.triangles.triangles)
    triangles.emplace_back(cap.triangles.points[t[0]], cap.triangles.points[t[1]], cap.triangles.points[t[2]]);
  const CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>> tree(triangles.begin(), triangles.end());
  const auto is_on_cap = [&](Face f) {
    const auto [nearest, triangle] = tree.closest_point_and_primitive(point(centroid(mesh, f)));
    if ((vec(nearest) - centroid(mesh, f)).norm() > on_cap * radius)
      return false;
    const Vec3 area = area_vector(mesh, f);
    const Vec3 a = vec(triangle->vertex(0)), b = vec(triangle->vertex(1)), c = vec(triangle->vertex(2));
    const Vec3 of_cap = (b - a).cross(Vec3(c - a));
    if (std::abs(area.dot(of_cap)) >= cos_cap * area.norm() * of_cap.norm())
      return true;
    const auto corners = mesh.vertices_around_face(mesh.halfedge(f));
    return std::all_of(corners.begin(), corners.end(),
                       [&](Vertex v) { return std::sqrt(tree.squared_distance(mesh.point(v))) < same_point * radius; });
  };
  std::vector<Face> faces;
  std::copy_if(mesh.faces().begin(), mesh.faces().end(), std::back_inserter(faces), is_on_cap);
  return faces;
}

// Whether the surface already has an end at the cap: an opening, or faces that it tags.
bool is_known(const Mesh& mesh, const GivenCap& cap) {
  const double near = 0.5 * std::sqrt(cap.area / M_PI);
  const auto is_near = [&](const Vec3& centre) { return (centre - cap.centre).norm() < near; };
  const auto tagged = tagged_faces(mesh);
  const auto loops = boundary_loops(mesh);
  return std::any_of(loops.begin(), loops.end(), [&](const Loop& loop) { return is_near(loop.centre); }) ||
         std::any_of(tagged.begin(), tagged.end(),
                     [&](const auto& one) { return is_near(plane_of(mesh, one.second).centre); });
}

} // namespace

void open_given_caps(Mesh& mesh, const std::vector<GivenCap>& caps) {
  for (const GivenCap& cap : caps) {
    if (is_known(mesh, cap))
      continue;
    const std::vector<Face> faces = faces_on(mesh, cap);
    double covered = 0;
    for (Face f : faces)
      covered += area_vector(mesh, f).norm();
    if (covered < least_covered * cap.area)
      throw InputError("no end of the vessel at a given cap", cap.path,
                       "its centre " + place(cap.centre) + ", area " + std::to_string(cap.area) + " mm2", check_frame);
    const std::size_t before = boundary_loops(mesh).size();
    for (Face f : faces)
      CGAL::Euler::remove_face(mesh.halfedge(f), mesh);
    mesh.collect_garbage();
    const std::size_t openings = boundary_loops(mesh).size();
    if (openings != before + 1)
      throw InputError("a given cap does not close one end of the vessel", cap.path,
                       "without its faces the surface has " + std::to_string(openings) + " openings, with them " +
                           std::to_string(before),
                       "give the triangles that close this end, and no others");
  }
}

} // namespace anatomy
