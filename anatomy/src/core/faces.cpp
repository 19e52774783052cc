#include "core/faces.hpp"

namespace anatomy {

Vec3 area_vector(const Mesh& mesh, Face f) {
  const Halfedge h = mesh.halfedge(f);
  const Vec3 a = vec(mesh.point(mesh.source(h))), b = vec(mesh.point(mesh.target(h))),
             c = vec(mesh.point(mesh.target(mesh.next(h))));
  return 0.5 * (b - a).cross(Vec3(c - a));
}

Vec3 centroid(const Mesh& mesh, Face f) {
  Vec3 sum = Vec3::Zero();
  for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
    sum += vec(mesh.point(v));
  return sum / 3;
}

} // namespace anatomy
