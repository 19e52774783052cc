#include "ends/ragged_ends.hpp"
#include "common/error.hpp"
#include "core/faces.hpp"
#include "core/measures.hpp"
#include "ends/cap_open_ends.hpp"
#include <algorithm>
#include <optional>

namespace anatomy {
namespace {
using common::InputError;

constexpr double cap_area_tolerance = 0.02; // largest relative change of a sound cap's area
// Largest distance of a sound cap's vertices from its plane, in edge lengths.
constexpr double cap_height_tolerance = 0.25;
// Largest relative difference between the area of a section and the area within the sawtooth rim.
constexpr double rim_area_tolerance = 0.25;
constexpr double section_area_tolerance = 0.05; // largest relative difference between the areas of like sections
// Largest difference between the steps from one section's centre to the next, in radii.
constexpr double step_tolerance = 0.05;
constexpr int most_attempts = 8; // largest number of planes tried, each an edge length farther in

// The vertex nearest to p (mm) on the side that the plane cuts off. Repairs may have moved the rim's corners, so p may
// be no vertex.
Vertex vertex_before(const Mesh& mesh, const Plane& plane, const Vec3& p) {
  Vertex best = Mesh::null_vertex();
  double least = 1e300;
  for (Vertex v : mesh.vertices()) {
    const Vec3 q = vec(mesh.point(v));
    if ((q - p).norm() < least && plane.normal.dot(Vec3(q - plane.centre)) < 0) {
      least = (q - p).norm();
      best = v;
    }
  }
  return best;
}

// Whether the repair of self-intersections has changed the cap that closed the end, or crumpled it.
bool is_damaged(const Mesh& mesh, const OpenEnd& end) {
  const RegionMap region = region_map(mesh);
  Vec3 total = Vec3::Zero();
  double sum = 0, off = 0;
  for (Face f : mesh.faces()) {
    if (region[f] != end.tag)
      continue;
    const Vec3 area = area_vector(mesh, f), b = vec(mesh.point(mesh.target(mesh.halfedge(f))));
    total += area;
    sum += area.norm();
    off = std::max(off, std::abs(end.plane.normal.dot(Vec3(b - end.centre))));
  }
  return std::abs(total.norm() / end.area - 1) > cap_area_tolerance || sum > (1 + cap_area_tolerance) * total.norm() ||
         off > cap_height_tolerance * end.spacing;
}

// A mesh after an end was cut off, and the opening that the cut left.
struct OpenedMesh {
  Mesh mesh;
  Loop loop;
  double lost, depth; // mm2 of wall and mm of vessel that were cut off
};

// Cuts a copy of the mesh by `plane`, which lies `deeper` mm behind the end's own plane. Returns nothing if the cut
// fails or does not leave exactly one opening, or if the opening's area differs from the rim's by more than
// rim_area_tolerance.
std::optional<OpenedMesh> open_behind(const Mesh& mesh, const OpenEnd& end, const Plane& plane, double deeper) {
  OpenedMesh out{mesh, {}, 0, end.depth + deeper};
  try {
    out.lost = cut_at_plane(out.mesh, plane, vertex_before(out.mesh, plane, end.outermost), cut_remedy);
  } catch (const InputError&) {
    return std::nullopt;
  }
  out.mesh.collect_garbage();
  const std::vector<Loop> loops = boundary_loops(out.mesh);
  if (loops.size() != 1 || std::abs(loops[0].area / end.area - 1) > rim_area_tolerance)
    return std::nullopt;
  out.loop = loops[0];
  return out;
}

// Whether three sections are of one vessel: their areas are alike, and the steps between their centres are equal. The
// rim may be oblique, so the steps need not be along the planes' normal.
bool are_alike(const OpenedMesh& a, const OpenedMesh& b, const OpenedMesh& c) {
  const Vec3 bend = (c.loop.centre - b.loop.centre) - (b.loop.centre - a.loop.centre);
  return std::abs(b.loop.area / a.loop.area - 1) < section_area_tolerance &&
         std::abs(c.loop.area / b.loop.area - 1) < section_area_tolerance &&
         bend.norm() < step_tolerance * std::sqrt(a.loop.area / pi);
}

// Cuts behind the end at the first plane whose section is like the sections of the next two planes, an edge apart.
// Nearer to the rim the temporary closure may reach inside, and the wall may be crumpled.
OpenedMesh cut_behind(const Mesh& mesh, const OpenEnd& end) {
  std::optional<OpenedMesh> first, second;
  Plane plane = end.plane;
  for (int attempt = 0; attempt < most_attempts; ++attempt) {
    std::optional<OpenedMesh> third = open_behind(mesh, end, plane, attempt * end.spacing);
    if (third) // behind an oblique rim the vessel does not run along the planes' normal
      plane.centre = third->loop.centre;
    plane.centre += end.spacing * plane.normal;
    if (first && second && third && are_alike(*first, *second, *third))
      return *std::move(first);
    first = std::move(second);
    second = std::move(third);
  }
  char value[160];
  std::snprintf(value, sizeof value, "diameter %.2f mm; no three like sections within %.1f mm behind its rim",
                2 * std::sqrt(end.area / pi), end.depth + (most_attempts - 1) * end.spacing);
  throw InputError("an open end is too ragged to be cut flat", point_text(end.centre), value,
                   std::string(cut_remedy) + "; if no vessel ends there, the wall is torn: fill the hole");
}

void untag(Mesh& mesh, int tag) {
  RegionMap region = region_map(mesh);
  for (Face f : mesh.faces())
    if (region[f] == tag)
      region[f] = 0;
}

} // namespace

void cut_ragged(Mesh& mesh, const std::vector<OpenEnd>& ends, std::vector<Repair>& repairs) {
  remove_isolated_vertices(mesh);
  mesh.collect_garbage();
  for (const OpenEnd& end : ends) {
    if (!end.ragged && !is_damaged(mesh, end))
      continue;
    if (!end.ragged)
      untag(mesh, end.tag);
    OpenedMesh cut_end = cut_behind(mesh, end);
    mesh = std::move(cut_end.mesh);
    char detail[192];
    std::snprintf(detail, sizeof detail, "at %s: %.2f mm of the vessel and %.2f mm2 of wall dropped, %s",
                  point_text(end.centre).c_str(), cut_end.depth, cut_end.lost,
                  end.ragged ? "since its rim is a sawtooth" : "since the wall crosses itself at its rim");
    repairs.push_back({"ragged end cut flat", 1, detail, true});
    cap_open_ends(mesh, repairs);
  }
}

} // namespace anatomy
