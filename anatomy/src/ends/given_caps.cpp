#include "ends/given_caps.hpp"
#include "common/error.hpp"
#include "core/faces.hpp"
#include "ends/planar_patches.hpp"
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <algorithm>

namespace anatomy {
namespace {

using common::InputError;
using Iterator = std::vector<Kernel::Triangle_3>::const_iterator;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Iterator>;

constexpr double on_cap = 0.02;       // radii between a face's centre and the cap that it lies on
constexpr double cos_cap = 0.9;       // 26 degrees between their normals
constexpr double least_covered = 0.5; // of the cap's area, by the faces that lie on it
} // namespace

void tag_given_caps(Mesh& mesh, const std::vector<GivenCap>& caps) {
  RegionMap region = region_map(mesh);
  std::vector<Vec3> known;
  int next = 0;
  for (const auto& [tag, faces] : tagged_faces(mesh)) {
    known.push_back(plane_of(mesh, faces).centre);
    next = std::max(next, tag);
  }
  for (const GivenCap& cap : caps) {
    const double radius = std::sqrt(cap.area / M_PI);
    if (std::any_of(known.begin(), known.end(),
                    [&](const Vec3& centre) { return (centre - cap.centre).norm() < 0.5 * radius; }))
      continue;
    std::vector<Kernel::Triangle_3> triangles;
    for (const Triangle& t : cap.triangles.triangles)
      triangles.emplace_back(cap.triangles.points[t[0]], cap.triangles.points[t[1]], cap.triangles.points[t[2]]);
    const CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>> tree(triangles.begin(), triangles.end());
    ++next;
    double covered = 0;
    for (Face f : mesh.faces()) {
      const Vec3 area = area_vector(mesh, f);
      if (std::abs(area.dot(cap.normal)) < cos_cap * area.norm() ||
          std::sqrt(tree.squared_distance(point(centroid(mesh, f)))) > on_cap * radius)
        continue;
      region[f] = next;
      covered += area.norm();
    }
    if (covered < least_covered * cap.area && cap.flatness < cos_cap)
      throw InputError("a given cap is not flat", cap.path, "at " + place(cap.centre),
                       "name the ends by --inlet and --outlet: rounded ones are cut flat");
    if (covered < least_covered * cap.area)
      throw InputError("no end of the vessel at a given cap", cap.path,
                       "its centre " + place(cap.centre) + ", area " + std::to_string(cap.area) + " mm2",
                       "check that cap and surface are in the same frame and unit");
  }
}

} // namespace anatomy
