#include "ends/cap_open_ends.hpp"
#include "common/error.hpp"
#include "repair/fill_hole.hpp"
#include <algorithm>

namespace anatomy {
namespace {

using common::InputError;

// Moves the loop's corners onto its plane; returns the largest move in mm.
double onto_plane(Mesh& mesh, const Loop& loop) {
  double farthest = 0;
  for (Vertex v : CGAL::vertices_around_face(loop.halfedge, mesh)) {
    const Vec3 p = vec(mesh.point(v));
    const double off = loop.normal.dot(Vec3(p - loop.centre));
    mesh.point(v) = point(p - off * loop.normal);
    farthest = std::max(farthest, std::abs(off));
  }
  return farthest;
}

} // namespace

std::vector<OpenEnd> cap_open_ends(Mesh& mesh, std::vector<Repair>& repairs) {
  RegionMap region = region_map(mesh);
  std::vector<OpenEnd> open;
  int next = 0;
  for (Face f : mesh.faces())
    next = std::max(next, region[f]);
  for (const Loop& loop : boundary_loops(mesh)) {
    OpenEnd end = open_end(mesh, loop);
    const double farthest = end.ragged ? 0 : onto_plane(mesh, loop);
    const std::vector<Face> faces = end.ragged ? closed_as_it_is(mesh, loop, end) : capped(mesh, loop);
    if (faces.empty())
      throw InputError("an open end cannot be closed", place(loop.centre),
                       std::to_string(loop.halfedges) + " edges round it", cut_remedy);
    if (!end.ragged) {
      end.tag = ++next;
      for (Face f : faces)
        region[f] = next;
      char detail[128];
      std::snprintf(detail, sizeof detail, "radius %.3f mm at %s, rim moved %.4f mm", std::sqrt(loop.area / M_PI),
                    place(loop.centre).c_str(), farthest);
      repairs.push_back({"open end capped", 1, detail});
    }
    open.push_back(end);
  }
  return open;
}

} // namespace anatomy
