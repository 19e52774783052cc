#include "ends/ends.hpp"
#include "core/faces.hpp"
#include "core/tags.hpp"
#include "ends/planar_patches.hpp"
#include "repair/loops.hpp"
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <algorithm>
#include <set>

namespace anatomy {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;

std::set<Vertex> vertices_of(const Mesh& mesh, const std::vector<Face>& faces) {
  std::set<Vertex> vertices;
  for (Face f : faces)
    for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
      vertices.insert(v);
  return vertices;
}

End measure_end(const Mesh& mesh, const std::vector<Face>& faces) {
  End end;
  Vec3 total = Vec3::Zero();
  double weight = 0;
  for (Face f : faces) {
    const Vec3 a = area_vector(mesh, f);
    total += a;
    weight += a.norm();
    end.centre += a.norm() * centroid(mesh, f);
  }
  end.centre /= weight;
  end.area = total.norm();
  end.normal = total / end.area;
  return end;
}

// The faces of each connected cap, in a stable order.
std::map<std::size_t, std::vector<Face>> cap_patches(Mesh& mesh) {
  const RegionMap region = region_map(mesh);
  auto patch = mesh.add_property_map<Face, std::size_t>("f:patch").first;
  auto rim = mark_rims(mesh);
  PMP::connected_components(mesh, patch, CGAL::parameters::edge_is_constrained_map(rim));
  std::map<std::size_t, std::vector<Face>> caps;
  for (Face f : mesh.faces())
    if (region[f] != 0)
      caps[patch[f]].push_back(f);
  mesh.remove_property_map(patch);
  mesh.remove_property_map(rim);
  return caps;
}

} // namespace

void tag_from_soup(Mesh& mesh, const Soup& soup) {
  using Iterator = std::vector<Kernel::Triangle_3>::const_iterator;
  using Primitive = CGAL::AABB_triangle_primitive<Kernel, Iterator>;
  std::vector<Kernel::Triangle_3> triangles;
  for (const Triangle& t : soup.triangles)
    triangles.emplace_back(soup.points[t[0]], soup.points[t[1]], soup.points[t[2]]);
  CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>> tree(triangles.begin(), triangles.end());
  RegionMap region = region_map(mesh);
  for (Face f : mesh.faces()) {
    const auto nearest = tree.closest_point_and_primitive(point(centroid(mesh, f))).second;
    region[f] = soup.region[static_cast<std::size_t>(nearest - triangles.cbegin())];
  }
}

void drop_scraps_of_caps(Mesh& mesh, const std::set<int>& single_cap_tags, std::vector<Repair>& repairs) {
  RegionMap region = region_map(mesh);
  const auto patches = cap_patches(mesh);
  std::map<int, double> largest;
  for (const auto& [id, faces] : patches)
    largest[region[faces[0]]] = std::max(largest[region[faces[0]]], measure_end(mesh, faces).area);
  for (const auto& [id, faces] : patches)
    if (const End end = measure_end(mesh, faces);
        end.area < largest[region[faces[0]]] && // projected area, since scraps are crumpled
        (end.radius() < smallest_end || single_cap_tags.contains(region[faces[0]]))) {
      repairs.push_back({"scrap of a cap taken as wall", faces.size(), "at " + point_text(centroid(mesh, faces[0]))});
      for (Face f : faces)
        region[f] = 0;
    }
}

CapMove flatten_caps(Mesh& mesh) {
  CapMove largest;
  for (const auto& [id, faces] : tagged_faces(mesh)) {
    const End end = measure_end(mesh, faces);
    for (Vertex v : vertices_of(mesh, faces)) {
      const Vec3 p = vec(mesh.point(v));
      const double off = end.normal.dot(Vec3(p - end.centre));
      mesh.point(v) = point(p - off * end.normal);
      largest.share = std::max(largest.share, std::abs(off) / end.radius());
      if (std::abs(off) > largest.distance) {
        largest.distance = std::abs(off);
        largest.moved_to = vec(mesh.point(v));
      }
    }
  }
  return largest;
}

std::vector<End> measure_ends(Mesh& mesh) {
  RegionMap region = region_map(mesh);
  std::vector<std::pair<End, std::vector<Face>>> found;
  for (const auto& [id, faces] : cap_patches(mesh))
    found.emplace_back(measure_end(mesh, faces), faces);
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first.area > b.first.area; });
  std::vector<End> ends;
  for (auto& [end, faces] : found) {
    end.region = static_cast<int>(ends.size()) + 1;
    for (Face f : faces)
      region[f] = end.region;
    ends.push_back(end);
  }
  return ends;
}

} // namespace anatomy
