#include "ends/cap_open_ends.hpp"
#include "common/error.hpp"
#include "core/faces.hpp"
#include "ends/evidence.hpp"
#include "repair/fill_hole.hpp"
#include <algorithm>

namespace anatomy {
namespace {

using common::InputError;

constexpr double opening_naming_radii = 3; // a point within this many radii of an opening's centre names the opening

// Moves the loop's corners onto its plane; returns the largest move in mm.
double move_onto_plane(Mesh& mesh, const Loop& loop) {
  double farthest = 0;
  for (Vertex v : CGAL::vertices_around_face(loop.halfedge, mesh)) {
    const Vec3 p = vec(mesh.point(v));
    const double off = loop.normal.dot(Vec3(p - loop.centre));
    mesh.point(v) = point(p - off * loop.normal);
    farthest = std::max(farthest, std::abs(off));
  }
  return farthest;
}

// 1 if the faces' normals point outward, -1 if inward. The sign of the enclosed volume tells, with each opening closed
// by a fan.
double normal_sense(const Mesh& mesh, const std::vector<Loop>& loops) {
  double volume = 0;
  for (Face f : mesh.faces())
    volume += area_vector(mesh, f).dot(centroid(mesh, f)) / 3;
  for (const Loop& loop : loops)
    volume += loop.area * loop.normal.dot(loop.centre) / 3;
  return volume < 0 ? -1 : 1;
}

// The point on the opening's axis at the height of the rim's innermost corner. A sphere that touches this point from
// the inside contains no corner of the rim.
Vec3 innermost(const Mesh& mesh, const Loop& loop, const Vec3& inward) {
  double deepest = 0;
  for (Vertex v : CGAL::vertices_around_face(loop.halfedge, mesh))
    deepest = std::max(deepest, inward.dot(Vec3(vec(mesh.point(v)) - loop.centre)));
  return loop.centre + deepest * inward;
}

// Whether one of the points (mm) is near enough to the opening to name it.
bool is_named(const Loop& loop, const std::vector<Vec3>& named) {
  const double reach = opening_naming_radii * std::sqrt(loop.area / pi);
  return std::any_of(named.begin(), named.end(), [&](const Vec3& p) { return (p - loop.centre).norm() < reach; });
}

// Radius (mm) of the largest sphere in the vessel behind the opening.
double sphere_radius_behind(const Mesh& mesh, const VesselProbe& probe, double sense, const Loop& loop) {
  const Vec3 inward = -sense * loop.normal;
  return probe.sphere_radius(innermost(mesh, loop, inward), inward);
}

// Whether the opening is too narrow for an end of a vessel that holds a sphere of this radius (mm).
bool is_narrower(const Loop& loop, double sphere_radius) {
  return std::sqrt(loop.area / pi) < least_width * sphere_radius;
}

} // namespace

IsGivenEnd ends_at_points(std::vector<Vec3> points) {
  return [points = std::move(points)](const Mesh& mesh, const Loop& loop) {
    return is_named(loop, points) &&
           !is_narrower(loop,
                        sphere_radius_behind(mesh, VesselProbe(mesh), normal_sense(mesh, boundary_loops(mesh)), loop));
  };
}

void fill_tears(Mesh& mesh, const std::vector<Vec3>& named, std::vector<Repair>& repairs) {
  const std::vector<Loop> loops = boundary_loops(mesh);
  if (loops.empty())
    return;
  const double sense = normal_sense(mesh, loops);
  std::vector<std::pair<Loop, double>> tears;
  {
    const VesselProbe probe(mesh);
    for (const Loop& loop : loops)
      if (!is_named(loop, named))
        if (const double radius = sphere_radius_behind(mesh, probe, sense, loop); is_narrower(loop, radius))
          tears.emplace_back(loop, radius);
  }
  for (const auto& [loop, sphere_radius] : tears) {
    if (fill_hole(mesh, loop.halfedge).empty())
      throw InputError("a hole in the wall cannot be filled", point_text(loop.centre),
                       std::to_string(loop.halfedges) + " edges round it", "repair the surface there");
    char detail[200];
    std::snprintf(detail, sizeof detail,
                  "%zu edges at %s, diameter %.2f mm, the vessel behind it %.2f mm; if a vessel ends there, name it by "
                  "--inlet or --outlet",
                  loop.halfedges, point_text(loop.centre).c_str(), 2 * std::sqrt(loop.area / pi), 2 * sphere_radius);
    repairs.push_back({"opening taken for a tear in the wall", 1, detail, true});
  }
  mesh.collect_garbage();
}

std::vector<OpenEnd> cap_open_ends(Mesh& mesh, std::vector<Repair>& repairs) {
  RegionMap region = region_map(mesh);
  std::vector<OpenEnd> open;
  int next = 0;
  for (Face f : mesh.faces())
    next = std::max(next, region[f]);
  for (const Loop& loop : boundary_loops(mesh)) {
    OpenEnd end = open_end(mesh, loop);
    const double farthest = end.ragged ? 0 : move_onto_plane(mesh, loop);
    const std::vector<Face> faces = end.ragged ? close_unflattened(mesh, loop, end) : cap_loop(mesh, loop);
    if (faces.empty())
      throw InputError("an open end cannot be closed", point_text(loop.centre),
                       std::to_string(loop.halfedges) + " edges round it", cut_remedy);
    if (!end.ragged) {
      end.tag = ++next;
      for (Face f : faces)
        region[f] = next;
      char detail[128];
      std::snprintf(detail, sizeof detail, "radius %.3f mm at %s, rim moved %.4f mm", std::sqrt(loop.area / pi),
                    point_text(loop.centre).c_str(), farthest);
      repairs.push_back({"open end capped", 1, detail});
    }
    open.push_back(end);
  }
  return open;
}

} // namespace anatomy
