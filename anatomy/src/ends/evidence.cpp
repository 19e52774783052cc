#include "ends/evidence.hpp"
#include "core/faces.hpp"
#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <algorithm>
#include <set>

namespace anatomy {
namespace {

using FacePrimitive = CGAL::AABB_face_graph_triangle_primitive<Mesh>;
using FaceTree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, FacePrimitive>>;

// Largest growth (`growth`) between a flat part and the section behind it, either way, if the part is an end. It allows
// a vessel that widens or narrows by 40 degrees on each side.
constexpr double largest_growth = 2;
// Largest growth from a flat part to the section on a rough surface. One plane may hold only a piece of a cap.
constexpr double rough_part_growth = 1.25;
constexpr double most_flat_height = 0.07; // largest height difference of a flat part's vertices, in its diameters
constexpr double cos_tilt = 0.5;          // cosine of the largest tilt, 60 degrees
// Depth of the section behind a flat part, in radii of the part. It is small, since an outlet that was cut off close to
// its parent may be this short.
constexpr double section_depth_radii = 0.5;
// The tilt is measured on wall farther behind the flat part than this, in radii of the part. A rounded rim is neither
// cap nor wall.
constexpr double rim_depth_radii = 0.25;
constexpr double largest_sphere = 20; // mm, radius at which the shrinking of the sphere starts: wider than any aorta
constexpr int most_shrinks = 40;      // largest number of times that the sphere is shrunk

} // namespace

struct VesselProbe::SearchTrees {
  FaceTree faces;
  Slices slices;
  explicit SearchTrees(const Mesh& mesh) : faces(mesh.faces().begin(), mesh.faces().end(), mesh), slices(mesh) {}
};

VesselProbe::VesselProbe(const Mesh& mesh) : mesh_(mesh), search_trees_(std::make_shared<SearchTrees>(mesh)) {}

std::string no_end_reason(const PatchPlane& plane, const EndEvidence& evidence, bool rough) {
  if (plane.width < least_width * 2 * evidence.sphere_radius)
    return "a facet of the wall: narrower than the vessel behind it";
  if (plane.highest - plane.lowest > 2 * most_flat_height * std::sqrt(plane.area / pi))
    return "not flat";
  if (evidence.section.area <= 0)
    return "no vessel behind it";
  const SectionSize part = plane.size();
  if (growth(part, evidence.section) > largest_growth || growth(evidence.section, part) > largest_growth)
    return "the vessel half a radius behind it is of another size";
  if (rough && growth(part, evidence.section) > rough_part_growth)
    return "only a part of a rough end";
  if (evidence.tilt > std::acos(cos_tilt) * 180 / pi)
    return "along the vessel, not across it";
  return "";
}

// Shrinks a large sphere until no part of the surface reaches into it.
double VesselProbe::sphere_radius(const Vec3& from, const Vec3& inward) const {
  double radius = largest_sphere;
  for (int step = 0; step < most_shrinks; ++step) {
    const Vec3 centre = from + radius * inward;
    const Vec3 reach = vec(search_trees_->faces.closest_point(point(centre))) - from;
    const double height = reach.dot(inward);
    if ((reach + from - centre).norm() > radius * (1 - 1e-4) || height <= 0)
      break;
    radius = reach.squaredNorm() / (2 * height);
  }
  return radius;
}

double VesselProbe::tilt(const std::vector<Face>& patch, const PatchPlane& plane) const {
  const double radius = std::sqrt(plane.area / pi);
  std::set<Face> seen(patch.begin(), patch.end());
  std::vector<Face> wall;
  const auto add_beside = [&](Face f, bool at_rim) {
    for (Face g : mesh_.faces_around_face(mesh_.halfedge(f))) {
      const Vec3 d = centroid(mesh_, g) - plane.centre;
      const bool near = d.dot(plane.normal) > -radius && d.norm() < 2 * radius;
      if ((at_rim || near) && seen.insert(g).second)
        wall.push_back(g);
    }
  };
  for (Face f : patch)
    add_beside(f, true);
  for (std::size_t i = 0; i < wall.size(); ++i)
    add_beside(wall[i], false);
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (Face f : wall)
    if (const Vec3 area = area_vector(mesh_, f);
        area.norm() > 0 && (centroid(mesh_, f) - plane.centre).dot(plane.normal) < -rim_depth_radii * radius)
      spread += area * area.transpose() / area.norm();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  return std::acos(std::min(1.0, std::abs(axes.eigenvectors().col(0).dot(plane.normal)))) * 180 / pi;
}

EndEvidence VesselProbe::evidence(const std::vector<Face>& patch, const PatchPlane& plane) const {
  EndEvidence out;
  // The sphere starts at the height of the innermost vertex, so that the part's own noise does not reach into it.
  out.sphere_radius = sphere_radius(plane.centre + plane.lowest * plane.normal, -plane.normal);
  if (plane.width < least_width * 2 * out.sphere_radius)
    return out;
  const double depth = section_depth_radii * std::sqrt(plane.area / pi);
  out.section = search_trees_->slices.section_size({plane.centre - depth * plane.normal, plane.normal});
  out.tilt = tilt(patch, plane);
  return out;
}

} // namespace anatomy
