#include "core/tags.hpp"

namespace anatomy {

Mesh::Property_map<Edge, bool> mark_rims(Mesh& mesh) {
  const RegionMap region = region_map(mesh);
  auto rim = mesh.add_property_map<Edge, bool>("e:rim", false).first;
  for (Edge e : mesh.edges()) {
    const Halfedge h = mesh.halfedge(e);
    rim[e] = region[mesh.face(h)] != region[mesh.face(mesh.opposite(h))];
  }
  return rim;
}

bool touches_cap(const Mesh& mesh, Face f) {
  const RegionMap region = region_map(mesh);
  for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
    for (Face g : mesh.faces_around_target(mesh.halfedge(v)))
      if (region[g] != 0)
        return true;
  return false;
}

} // namespace anatomy
