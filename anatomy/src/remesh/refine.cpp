#include "remesh/refine.hpp"
#include "core/measures.hpp"

namespace anatomy {
namespace {

constexpr double cos_sharp = 0.8;      // 37 degrees between the normals at an edge's ends: sharper edges stay straight
constexpr double largest_bulge = 0.01; // mm, largest move of a new middle off its edge; a blunt crease would give more
constexpr double cos_turn = 0.98;   // 0.2 rad between the normals, as at the ends of an edge of a fifth of the radius
constexpr double thin_share = 0.03; // least share of the wall's area that must turn so; a side branch reaches it
constexpr std::size_t most_to_split = 150000; // triangles; on finer surfaces noise turns as much, and splitting is slow

// Vertex normals from the wall's faces alone, so that a vertex on a rim has the normal of the wall. They are 0 inside a
// cap.
std::vector<Vec3> wall_normals(const Mesh& mesh) {
  const RegionMap region = region_map(mesh);
  std::vector<Vec3> normals(mesh.number_of_vertices(), Vec3::Zero());
  for (Face f : mesh.faces()) {
    if (region[f] != 0)
      continue;
    const Halfedge h = mesh.halfedge(f);
    const Vec3 a = vec(mesh.point(mesh.source(h))), b = vec(mesh.point(mesh.target(h))),
               c = vec(mesh.point(mesh.target(mesh.next(h))));
    const Vec3 area = (b - a).cross(Vec3(c - a));
    for (Vertex v : mesh.vertices_around_face(h))
      normals[v] += area;
  }
  for (Vec3& normal : normals)
    if (normal.norm() > 0)
      normal.normalize();
  return normals;
}

// The new middle (mm) of the edge from p to q, whose ends have the normals np and nq.
Vec3 middle(const Vec3& p, const Vec3& q, const Vec3& np, const Vec3& nq) {
  const Vec3 straight = 0.5 * (p + q);
  if (np.dot(nq) < cos_sharp) // also true inside a cap, where a normal is zero
    return straight;
  const Vec3 d = q - p, bulge = (d.dot(nq) * nq - d.dot(np) * np) / 8; // middle of a Hermite cubic: (t_p - t_q) / 8
  return straight + std::min(1.0, largest_bulge / std::max(bulge.norm(), largest_bulge)) * bulge;
}

} // namespace

namespace {

// Share of the wall's area in triangles whose normals turn by more than 0.2 rad from corner to corner. Sharp edges do
// not count.
double curved_area_share(const Mesh& mesh) {
  const std::vector<Vec3> normals = wall_normals(mesh);
  const RegionMap region = region_map(mesh);
  double turning = 0, total = 0;
  for (Face f : mesh.faces()) {
    if (region[f] != 0)
      continue;
    bool turns = false;
    for (Halfedge h : mesh.halfedges_around_face(mesh.halfedge(f))) {
      const double cosine = normals[mesh.source(h)].dot(normals[mesh.target(h)]);
      turns = turns || (cosine < cos_turn && cosine > cos_sharp);
    }
    const double area = face_area(mesh, f);
    turning += turns ? area : 0;
    total += area;
  }
  return turning / total;
}

} // namespace

bool is_coarse(const Mesh& mesh) {
  double edges = 0;
  for (Edge e : mesh.edges())
    edges += (vec(mesh.point(mesh.vertex(e, 0))) - vec(mesh.point(mesh.vertex(e, 1)))).norm();
  const double mean = edges / static_cast<double>(mesh.number_of_edges());
  return mean > 0.12 * mean_radius(mesh) ||
         (mesh.number_of_faces() < most_to_split && curved_area_share(mesh) > thin_share);
}

Mesh curved_refined(const Mesh& input) {
  Mesh mesh = input;
  mesh.collect_garbage(); // vertex indices then run from 0 without gaps
  const std::vector<Vec3> normals = wall_normals(mesh);
  const RegionMap region = region_map(mesh);
  Mesh out;
  RegionMap out_region = region_map(out);
  for (Vertex v : mesh.vertices())
    out.add_vertex(mesh.point(v));
  std::vector<Vertex> middles;
  for (Edge e : mesh.edges()) {
    const Vertex p = mesh.vertex(e, 0), q = mesh.vertex(e, 1);
    const Halfedge h = mesh.halfedge(e);
    const bool cap = region[mesh.face(h)] != 0 && region[mesh.face(mesh.opposite(h))] != 0;
    const Vec3 a = vec(mesh.point(p)), b = vec(mesh.point(q));
    middles.push_back(out.add_vertex(point(cap ? Vec3(0.5 * (a + b)) : middle(a, b, normals[p], normals[q]))));
  }
  for (Face f : mesh.faces()) {
    const Halfedge h = mesh.halfedge(f), k = mesh.next(h), l = mesh.next(k);
    const Vertex a = mesh.source(h), b = mesh.source(k), c = mesh.source(l);
    const Vertex ab = middles[mesh.edge(h)], bc = middles[mesh.edge(k)], ca = middles[mesh.edge(l)];
    for (const auto& t : {std::array{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}})
      out_region[out.add_face(t[0], t[1], t[2])] = region[f];
  }
  return out;
}

} // namespace anatomy
