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
#include <memory>

namespace anatomy {
namespace {

using common::InputError;
using Iterator = std::vector<Kernel::Triangle_3>::const_iterator;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

// Largest distance from a cap to the centre of a face that lies on it, in radii of the cap.
constexpr double on_cap_radii = 0.02;
// Cosine of the largest angle, 26 degrees, between a face on the cap and the cap's triangle nearest to it.
constexpr double least_cap_cosine = 0.9;
// A face's corner lies on the cap if it is nearer than this, in radii of the cap. Files store coordinates in single
// precision.
constexpr double same_point_radii = 1e-5;
constexpr double least_covered = 0.5; // least share of the cap's area that the faces on it must cover
// Largest mean distance between a cap and its end, in radii of the smaller one. Wall and cap may come from different
// meshes.
constexpr double rim_distance_radii = 0.5;
// Least sine of the angle between the cap and the faces beside the rim that it closes.
constexpr double least_turn_sine = 0.1;

double radius_of(double area) {
  return std::sqrt(area / pi);
}

// A given cap with a search tree of its triangles.
struct SearchableCap {
  explicit SearchableCap(const GivenCap& given) : radius(radius_of(given.area)) {
    for (const Triangle& t : given.triangles.triangles)
      triangles.emplace_back(given.triangles.points[t[0]], given.triangles.points[t[1]], given.triangles.points[t[2]]);
    tree.insert(triangles.begin(), triangles.end());
  }
  double distance(const Vec3& p) const { return std::sqrt(tree.squared_distance(point(p))); }

  double radius; // mm, of a circle with the cap's area
  std::vector<Kernel::Triangle_3> triangles;
  Tree tree;
};

// Whether the mean distance of the places from the cap is small, compared with the cap and with an end of this area
// (mm2).
bool lie_at_cap(const std::vector<Vec3>& places, double area, const SearchableCap& cap) {
  double sum = 0;
  for (const Vec3& p : places)
    sum += cap.distance(p);
  return sum < rim_distance_radii * std::min(cap.radius, radius_of(area)) * static_cast<double>(places.size());
}

// Whether the cap closes the opening: the rim lies on the cap, and the faces beside the rim do not. Only the rim is
// tested, since the middle of a dome may be far from the opening.
bool closes(const SearchableCap& cap, const Mesh& mesh, const Loop& loop) {
  std::vector<Vec3> rim;
  double from_cap = 0, from_rim_edge = 0; // sums of distances (mm) of the middles of the faces beside the rim
  for (Halfedge h : CGAL::halfedges_around_face(loop.halfedge, mesh)) {
    const Vec3 a = vec(mesh.point(mesh.source(h))), b = vec(mesh.point(mesh.target(h)));
    rim.push_back(b);
    const Vec3 middle = centroid(mesh, mesh.face(mesh.opposite(h)));
    from_cap += cap.distance(middle);
    from_rim_edge += (middle - a).cross(Vec3(middle - b)).norm() / (b - a).norm();
  }
  return from_cap > least_turn_sine * from_rim_edge && lie_at_cap(rim, loop.area, cap);
}

// The faces that lie on the cap. A face of almost no area has no reliable direction. So a face whose direction differs
// from the cap's still lies on the cap if all its corners do.
std::vector<Face> faces_on(const Mesh& mesh, const SearchableCap& cap) {
  const auto is_on_cap = [&](Face f) {
    const auto [nearest, triangle] = cap.tree.closest_point_and_primitive(point(centroid(mesh, f)));
    if ((vec(nearest) - centroid(mesh, f)).norm() > on_cap_radii * cap.radius)
      return false;
    const Vec3 area = area_vector(mesh, f);
    const Vec3 a = vec(triangle->vertex(0)), b = vec(triangle->vertex(1)), c = vec(triangle->vertex(2));
    const Vec3 of_cap = (b - a).cross(Vec3(c - a));
    if (std::abs(area.dot(of_cap)) >= least_cap_cosine * area.norm() * of_cap.norm())
      return true;
    const auto corners = mesh.vertices_around_face(mesh.halfedge(f));
    return std::all_of(corners.begin(), corners.end(),
                       [&](Vertex v) { return cap.distance(vec(mesh.point(v))) < same_point_radii * cap.radius; });
  };
  std::vector<Face> faces;
  std::copy_if(mesh.faces().begin(), mesh.faces().end(), std::back_inserter(faces), is_on_cap);
  return faces;
}

// Centres (mm) of the ends that the cap closes. They may be openings, or caps that the surface itself tags.
std::vector<Vec3> ends_closed_by(const Mesh& mesh, const SearchableCap& cap) {
  std::vector<Vec3> centres;
  for (const Loop& loop : boundary_loops(mesh))
    if (closes(cap, mesh, loop))
      centres.push_back(loop.centre);
  for (const auto& [tag, faces] : tagged_faces(mesh)) {
    std::vector<Vec3> places;
    for (Face f : faces)
      places.push_back(centroid(mesh, f));
    if (const PatchPlane plane = plane_of(mesh, faces); lie_at_cap(places, plane.area, cap))
      centres.push_back(plane.centre);
  }
  return centres;
}

// Removes the faces that lie on the cap. Throws InputError if they cover too little of it.
void remove_cap_faces(Mesh& mesh, const GivenCap& cap, const SearchableCap& searched) {
  const std::vector<Face> faces = faces_on(mesh, searched);
  double covered = 0;
  for (Face f : faces)
    covered += area_vector(mesh, f).norm();
  if (covered < least_covered * cap.area) {
    char value[200];
    std::snprintf(value, sizeof value,
                  "its centre %s, area %.3g mm2, of which the surface's triangles within %.3g mm of it cover %.0f %%",
                  point_text(cap.centre).c_str(), cap.area, on_cap_radii * searched.radius, 100 * covered / cap.area);
    throw InputError(
        "no end of the vessel at a given cap", cap.path, value,
        "give the surface's own triangles at this end, or a surface that is open there; check frame and unit");
  }
  for (Face f : faces)
    CGAL::Euler::remove_face(mesh.halfedge(f), mesh);
  mesh.collect_garbage();
}

} // namespace

IsGivenEnd ends_at_caps(const std::vector<GivenCap>& caps) {
  std::vector<std::shared_ptr<const SearchableCap>> searched; // shared pointers, since a std::function must be copyable
  for (const GivenCap& cap : caps)
    searched.push_back(std::make_shared<const SearchableCap>(cap));
  return [searched](const Mesh& mesh, const Loop& loop) {
    return std::any_of(searched.begin(), searched.end(), [&](const auto& cap) { return closes(*cap, mesh, loop); });
  };
}

std::vector<Vec3> open_given_caps(Mesh& mesh, const std::vector<GivenCap>& caps) {
  std::vector<Vec3> centres;
  for (const GivenCap& cap : caps) {
    const SearchableCap searched(cap);
    std::vector<Vec3> ends = ends_closed_by(mesh, searched);
    if (ends.empty()) {
      remove_cap_faces(mesh, cap, searched);
      ends = ends_closed_by(mesh, searched);
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
