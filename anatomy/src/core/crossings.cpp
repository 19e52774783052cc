#include "core/crossings.hpp"
#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>

namespace anatomy {
namespace PMP = CGAL::Polygon_mesh_processing;

std::vector<std::pair<Face, Face>> crossings(const Mesh& mesh) {
  std::vector<std::pair<Face, Face>> pairs;
  PMP::self_intersections(mesh, std::back_inserter(pairs));
  return pairs;
}

bool crosses_itself(const Mesh& mesh) {
  return PMP::does_self_intersect(mesh);
}

bool crosses_itself(const Mesh& mesh, const std::vector<Face>& faces) {
  return PMP::does_self_intersect(faces, mesh);
}

void replace_crossings(Mesh& mesh) {
  PMP::experimental::remove_self_intersections(mesh);
  mesh.collect_garbage();
}

} // namespace anatomy
