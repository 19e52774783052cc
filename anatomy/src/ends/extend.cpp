#include "ends/extend.hpp"
#include "common/error.hpp"
#include "core/crossings.hpp"
#include <algorithm>

namespace anatomy {
namespace {

struct Extruder {
  const Mesh& from;
  Mesh to;
  RegionMap region, new_region;

  explicit Extruder(const Mesh& mesh) : from(mesh), region(region_map(mesh)) { new_region = region_map(to); }

  Vertex moved(Vertex v, const Vec3& by) { return to.add_vertex(point(vec(from.point(v)) + by)); }

  // Adds `length` mm of straight wall at the rim of an end, in layers about as long as the rim's edges. `rim` maps each
  // old vertex of the rim to a new one: on entry to its copy on the rim, on return to its copy on the last layer.
  void add_wall(const End& end, double length, std::map<Vertex, Vertex>& rim) {
    std::vector<Halfedge> edges; // halfedges along the rim, on the wall's side
    double perimeter = 0;
    for (Halfedge h : from.halfedges())
      if (region[from.face(h)] == 0 && region[from.face(from.opposite(h))] == end.region) {
        edges.push_back(h);
        perimeter += (vec(from.point(from.target(h))) - vec(from.point(from.source(h)))).norm();
      }
    const double edge = perimeter / static_cast<double>(edges.size());
    const int layers = std::max(1, static_cast<int>(std::lround(length / edge)));
    for (int layer = 1; layer <= layers; ++layer) {
      std::map<Vertex, Vertex> next;
      for (Halfedge h : edges)
        next[from.source(h)] = moved(from.source(h), layer * length / layers * end.normal);
      for (Halfedge h : edges) {
        const Vertex a = from.target(h), b = from.source(h);
        new_region[to.add_face(rim[a], rim[b], next[b])] = 0;
        new_region[to.add_face(rim[a], next[b], next[a])] = 0;
      }
      rim = next;
    }
  }
};

// Throws InputError if triangles of the extended mesh cross.
void check_no_crossing(const Mesh& mesh) {
  const auto pairs = crossings(mesh);
  if (!pairs.empty())
    throw common::InputError("a flow extension meets the vessel or another extension",
                             point_text(vec(mesh.point(mesh.target(mesh.halfedge(pairs.front().first))))),
                             std::to_string(pairs.size()) + " pairs of triangles",
                             "extend less, or cut the ends so that they point apart");
}

} // namespace

Mesh extended(const Mesh& mesh, std::vector<End>& ends, const std::vector<double>& radii) {
  if (std::all_of(radii.begin(), radii.end(), [](double r) { return r == 0; }))
    return mesh;
  Extruder extruder(mesh);
  std::map<Vertex, Vertex> wall;
  for (Face f : mesh.faces())
    if (extruder.region[f] == 0)
      for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
        if (!wall.contains(v))
          wall[v] = extruder.moved(v, Vec3::Zero());
  const auto add = [&](Face f, std::map<Vertex, Vertex>& number) {
    const Halfedge h = mesh.halfedge(f);
    const Vertex a = mesh.source(h), b = mesh.target(h), c = mesh.target(mesh.next(h));
    extruder.new_region[extruder.to.add_face(number[a], number[b], number[c])] = extruder.region[f];
  };
  for (Face f : mesh.faces())
    if (extruder.region[f] == 0)
      add(f, wall);
  for (std::size_t e = 0; e < ends.size(); ++e) {
    const Vec3 shift = radii[e] * ends[e].radius() * ends[e].normal;
    std::map<Vertex, Vertex> number;
    for (Halfedge h : mesh.halfedges())
      if (extruder.region[mesh.face(h)] == 0 && extruder.region[mesh.face(mesh.opposite(h))] == ends[e].region)
        number[mesh.source(h)] = wall[mesh.source(h)];
    if (radii[e] > 0)
      extruder.add_wall(ends[e], shift.norm(), number);
    for (Face f : mesh.faces())
      if (extruder.region[f] == ends[e].region) {
        for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
          if (!number.contains(v))
            number[v] = extruder.moved(v, shift);
        add(f, number);
      }
    ends[e].centre += shift;
    ends[e].extension += shift.norm();
  }
  check_no_crossing(extruder.to);
  return extruder.to;
}

} // namespace anatomy
