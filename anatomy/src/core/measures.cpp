#include "core/measures.hpp"
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/repair.h>

namespace anatomy {
namespace PMP = CGAL::Polygon_mesh_processing;

double face_area(const Mesh& mesh, Face f) {
  return PMP::face_area(f, mesh);
}

double surface_area(const Mesh& mesh, const std::vector<Face>& faces) {
  return PMP::area(faces, mesh);
}

double surface_area(const Mesh& mesh) {
  return PMP::area(mesh);
}

double enclosed_volume(const Mesh& mesh) {
  return PMP::volume(mesh);
}

double mean_radius(const Mesh& mesh) {
  return 2 * std::abs(enclosed_volume(mesh)) / surface_area(mesh);
}

void remove_isolated_vertices(Mesh& mesh) {
  PMP::remove_isolated_vertices(mesh);
}

} // namespace anatomy
