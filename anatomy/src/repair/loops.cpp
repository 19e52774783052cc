#include "repair/loops.hpp"
#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/compute_normal.h>

namespace anatomy {
namespace PMP = CGAL::Polygon_mesh_processing;

std::vector<Loop> boundary_loops(const Mesh& mesh) {
  std::vector<Halfedge> cycles;
  PMP::extract_boundary_cycles(mesh, std::back_inserter(cycles));
  std::vector<Loop> loops;
  for (Halfedge h : cycles) {
    Loop loop;
    loop.halfedge = h;
    double length = 0;
    for (Halfedge k : CGAL::halfedges_around_face(h, mesh)) {
      const Vec3 a = vec(mesh.point(mesh.source(k))), b = vec(mesh.point(mesh.target(k)));
      loop.centre += (b - a).norm() * 0.5 * (a + b);
      length += (b - a).norm();
      ++loop.halfedges;
    }
    loop.centre /= length;
    Vec3 area = Vec3::Zero(); // the vector area is the normal of the plane that maximises the projected area
    for (Halfedge k : CGAL::halfedges_around_face(h, mesh))
      area +=
          0.5 *
          (vec(mesh.point(mesh.source(k))) - loop.centre).cross(Vec3(vec(mesh.point(mesh.target(k))) - loop.centre));
    loop.area = area.norm();
    loop.normal = loop.area > 0 ? Vec3(area / loop.area) : Vec3::UnitZ();
    loops.push_back(loop);
  }
  return loops;
}

bool is_open_end(const Mesh& mesh, const Loop& loop) {
  double along = 0;
  for (Halfedge h : CGAL::halfedges_around_face(loop.halfedge, mesh)) {
    const Vector n = PMP::compute_face_normal(mesh.face(mesh.opposite(h)), mesh);
    along += std::abs(loop.normal.dot(Vec3(n.x(), n.y(), n.z())));
  }
  return along / static_cast<double>(loop.halfedges) < 0.6;
}

} // namespace anatomy
