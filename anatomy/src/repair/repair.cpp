#include "repair/repair.hpp"
#include "common/error.hpp"
#include "core/crossings.hpp"
#include "core/measures.hpp"
#include "repair/fill_hole.hpp"
#include "repair/weld.hpp"
#include <CGAL/Polygon_mesh_processing/bbox.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>
#include <algorithm>

namespace anatomy {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using common::InputError;
using ComponentMap = Mesh::Property_map<Face, std::size_t>;

constexpr double comparable_area_ratio = 0.2; // a component with this share of the largest wall area may be a vessel
constexpr double vessel_length = 5; // mm; so may one with a box of this diagonal; voids and specks are shorter
// Two components may be the two sides of one wall if the inner box's diagonal has at least this share of the outer
// one's.
constexpr double wall_side_ratio = 0.9;
// The inner side may stand out of the outer side's box at an open end, by this share of that box's diagonal.
constexpr double box_tolerance = 0.02;

// Whether CGAL's orienting has reversed a triangle. `a` and `b` are the triangle's corners before and after. CGAL keeps
// the order of the triangles.
bool reversed(const std::vector<std::size_t>& a, const std::vector<std::size_t>& b) {
  const auto start = static_cast<std::size_t>(std::find(b.begin(), b.end(), a[0]) - b.begin());
  return start < 3 && b[(start + 1) % 3] == a[2];
}

Mesh oriented_mesh(const Soup& soup, std::vector<Repair>& repairs) {
  std::vector<Point> points = soup.points;
  std::vector<std::vector<std::size_t>> polygons;
  for (const Triangle& t : soup.triangles)
    polygons.emplace_back(t.begin(), t.end());
  const auto before = polygons;
  PMP::orient_polygon_soup(points, polygons);
  std::size_t turned = 0;
  for (std::size_t i = 0; i < polygons.size(); ++i)
    turned += reversed(before[i], polygons[i]);
  turned = std::min(turned, polygons.size() - turned);
  if (turned > 0)
    repairs.push_back({"triangles turned", turned, "their normals disagreed with their neighbours'"});
  if (points.size() > soup.points.size())
    repairs.push_back({"non-manifold points split", points.size() - soup.points.size(), ""});
  Mesh mesh;
  PMP::polygon_soup_to_polygon_mesh(points, polygons, mesh);
  return mesh;
}

// Throws InputError if a component lies within the box of the largest one and is nearly as long: the two are probably
// the inner and the outer side of a vessel's wall. `box` has the bounding box of each component.
void check_no_wall(const std::vector<Eigen::AlignedBox3d>& box, std::size_t largest) {
  const double length = box[largest].diagonal().norm();
  Eigen::AlignedBox3d outer = box[largest];
  outer.extend(Vec3(outer.max() + Vec3::Constant(box_tolerance * length)));
  outer.extend(Vec3(outer.min() - Vec3::Constant(box_tolerance * length)));
  for (std::size_t c = 0; c < box.size(); ++c) {
    if (c == largest || !outer.contains(box[c]) || box[c].diagonal().norm() < wall_side_ratio * length)
      continue;
    char value[96];
    std::snprintf(value, sizeof value, "%.1f mm long, within one of %.1f mm", box[c].diagonal().norm(), length);
    throw InputError("one surface lies inside another: are they the two sides of a vessel's wall?",
                     "round " + point_text(box[c].center()), value,
                     "export the lumen's surface, the inner one, alone; or name the inlet on its axis by --inlet");
  }
}

// Warns of each left-out component that may be a vessel: it has a fifth of the kept one's wall area, or is 5 mm long.
// The warning gives the places of both. `chosen` says that the user's inlet has chosen the kept component.
void warn_of_vessels(const Mesh& mesh, const ComponentMap& component, const std::vector<double>& area, std::size_t kept,
                     bool chosen, std::vector<Repair>& repairs) {
  std::vector<Vec3> centre(area.size(), Vec3::Zero());
  std::vector<Eigen::AlignedBox3d> box(area.size());
  for (Face f : mesh.faces()) {
    Vec3 middle = Vec3::Zero();
    for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f))) {
      middle += vec(mesh.point(v)) / 3;
      box[component[f]].extend(vec(mesh.point(v)));
    }
    centre[component[f]] += face_area(mesh, f) / area[component[f]] * middle;
  }
  if (!chosen)
    check_no_wall(box, kept);
  for (std::size_t c = 0; c < area.size(); ++c) {
    if (c == kept || (area[c] < comparable_area_ratio * area[kept] && box[c].diagonal().norm() < vessel_length))
      continue;
    char sizes[128];
    std::snprintf(sizes, sizeof sizes, "%.0f mm2 of wall, %.1f mm long, the one kept has %.0f mm2 ", area[c],
                  box[c].diagonal().norm(), area[kept]);
    repairs.push_back({"another vessel left out", 1,
                       "round " + point_text(centre[c]) + ": " + sizes + "round " + point_text(centre[kept]) +
                           "; --inlet chooses between trees; of one vessel in two pieces, join them",
                       true});
  }
}

// The component with the vertex nearest to p, among those with at least a fifth of the largest one's wall area.
std::size_t component_at(const Mesh& mesh, const ComponentMap& component, const std::vector<double>& area,
                         std::size_t largest, const Vec3& p) {
  std::size_t best = largest;
  double least = 1e300;
  for (Face f : mesh.faces())
    if (area[component[f]] >= comparable_area_ratio * area[largest])
      for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
        if (const double away = (vec(mesh.point(v)) - p).norm(); away < least) {
          least = away;
          best = component[f];
        }
  return best;
}

void keep_one_component(Mesh& mesh, const std::optional<Vec3>& inlet, std::vector<Repair>& repairs) {
  auto component = mesh.add_property_map<Face, std::size_t>("f:component").first;
  const std::size_t n = PMP::connected_components(mesh, component);
  if (n > 1) {
    std::vector<double> area(n, 0);
    for (Face f : mesh.faces())
      area[component[f]] += face_area(mesh, f);
    const auto largest = static_cast<std::size_t>(std::max_element(area.begin(), area.end()) - area.begin());
    const std::size_t kept = inlet ? component_at(mesh, component, area, largest, *inlet) : largest;
    double total = 0;
    for (double a : area)
      total += a;
    char detail[96];
    std::snprintf(detail, sizeof detail, "kept the %s of %zu, %.2f %% of the area",
                  kept == largest ? "largest" : "one with the inlet", n, 100 * area[kept] / total);
    repairs.push_back({"components dropped", n - 1, detail});
    warn_of_vessels(mesh, component, area, kept, inlet.has_value(), repairs);
    PMP::keep_connected_components(mesh, std::vector<std::size_t>{kept}, component);
  }
  mesh.remove_property_map(component);
}

// Closes gaps without width, at which an edge on one side faces several edges on the other. Triangles cannot fill such
// a gap, so the one edge is divided and the two sides are stitched.
void close_t_junctions(Mesh& mesh, double tolerance, std::vector<Repair>& repairs) {
  std::size_t count = 0;
  for (const Loop& loop : boundary_loops(mesh))
    count += divide_border(mesh, loop.halfedge, tolerance);
  if (count == 0)
    return;
  PMP::stitch_borders(mesh);
  repairs.push_back({"edges divided", count, "where points of the triangles beside them lie on them"});
}

void fill_holes(Mesh& mesh, const IsGivenEnd& is_given_end, std::vector<Repair>& repairs) {
  for (const Loop& loop : boundary_loops(mesh)) {
    if (is_open_end(mesh, loop) && std::sqrt(loop.area / pi) > smallest_end)
      continue;
    if (is_given_end && is_given_end(mesh, loop))
      continue;
    if (fill_hole(mesh, loop.halfedge).empty())
      throw InputError("a hole in the wall cannot be filled", point_text(loop.centre),
                       std::to_string(loop.halfedges) + " edges round it", "repair the surface there");
    repairs.push_back({"hole filled", 1, std::to_string(loop.halfedges) + " edges at " + point_text(loop.centre)});
  }
}

} // namespace

Mesh repaired(const Soup& soup, std::vector<Repair>& repairs, const IsGivenEnd& is_given_end,
              const std::optional<Vec3>& inlet) {
  CGAL::Bbox_3 box;
  for (const Point& p : soup.points)
    box += p.bbox();
  const double diagonal = Vec3(box.xmax() - box.xmin(), box.ymax() - box.ymin(), box.zmax() - box.zmin()).norm();
  Soup clean = welded(soup, weld_tolerance * diagonal, repairs);
  drop_degenerate_and_duplicate(clean, repairs);
  drop_fins(clean, repairs);
  if (clean.triangles.size() < 4)
    throw InputError("no surface remains after repair", "surface",
                     std::to_string(clean.triangles.size()) + " triangles", "check the file");
  Mesh mesh = oriented_mesh(clean, repairs);
  const std::size_t stitched = PMP::stitch_borders(mesh);
  if (stitched > 0)
    repairs.push_back({"borders stitched", stitched, "pairs of edges"});
  keep_one_component(mesh, inlet, repairs);
  PMP::remove_degenerate_faces(mesh);
  close_t_junctions(mesh, weld_tolerance * diagonal, repairs);
  fill_holes(mesh, is_given_end, repairs);
  mesh.collect_garbage();
  return mesh;
}

void orient_outward(Mesh& mesh, std::vector<Repair>& repairs) {
  // The sign of the volume tells whether normals point outward. CGAL's own test uses the highest vertex alone, where a
  // rough wall may be folded.
  if (enclosed_volume(mesh) >= 0)
    return;
  PMP::reverse_face_orientations(mesh);
  repairs.push_back({"normals turned outward", mesh.number_of_faces(), "the whole surface faced inward"});
}

void remove_self_intersections(Mesh& mesh, std::vector<Repair>& repairs) {
  const auto pairs = crossings(mesh);
  if (pairs.empty())
    return;
  const Vec3 where = vec(mesh.point(mesh.target(mesh.halfedge(pairs.front().first))));
  const std::size_t found = pairs.size();
  replace_crossings(mesh);
  if (crosses_itself(mesh) || !CGAL::is_closed(mesh))
    throw InputError("the surface crosses itself and could not be repaired", "near " + point_text(where),
                     std::to_string(found) + " pairs of triangles", "separate, smooth or re-segment the surface there");
  repairs.push_back({"self-intersections removed", found, "pairs of triangles, first near " + point_text(where)});
}

} // namespace anatomy
