#include "core/measures.hpp"
#include "ends/ends.hpp"
#include "remesh/refine.hpp"
#include "tube_mesh.hpp"
#include <CGAL/boost/graph/helpers.h>
#include <gtest/gtest.h>

using namespace anatomy;

namespace {

TEST(Refine, KeepsVerticesTagsAndTopology) {
  const Mesh mesh = shapes::mesh_of(shapes::straight(1.5, 10));
  Mesh fine = curved_refined(mesh);
  EXPECT_EQ(fine.number_of_faces(), 4 * mesh.number_of_faces());
  EXPECT_TRUE(CGAL::is_closed(fine));
  for (Vertex v : mesh.vertices())
    EXPECT_EQ(fine.point(v), mesh.point(v));
  const std::vector<End> ends = measure_ends(fine);
  ASSERT_EQ(ends.size(), 2u);
  EXPECT_NEAR(ends[0].radius(), 1.5, 0.004);
}

TEST(Refine, MiddlesComeToTheTrueCylinder) {
  shapes::Tube tube = shapes::straight(1.5, 10);
  tube.edge = 0.3;
  const Mesh mesh = shapes::mesh_of(tube);
  const Mesh fine = curved_refined(mesh);
  const RegionMap region = region_map(fine);
  for (Face f : fine.faces())
    if (region[f] == 0)
      for (Vertex v : fine.vertices_around_face(fine.halfedge(f))) {
        const Point& p = fine.point(v);
        EXPECT_NEAR(std::hypot(p.y(), p.z()), 1.5, 0.002); // the chords' middles lie 0.0075 inside
      }
  const double truth = pi * 1.5 * 1.5 * 10;
  const auto missing = [&](const Mesh& m) { return 1 - enclosed_volume(m) / truth; };
  EXPECT_GT(missing(mesh), 0.005);
  EXPECT_LT(missing(fine), 0.3 * missing(mesh));
  EXPECT_GT(missing(fine), 0);
}

TEST(Refine, NoMiddleIsFarFromItsEdge) {
  shapes::Tube tube = shapes::straight(1.5, 10);
  tube.edge = 0.6; // its chords' middles lie 0.03 inside
  const Mesh mesh = shapes::mesh_of(tube);
  const Mesh fine = curved_refined(mesh);
  double farthest = 0;
  for (std::size_t k = mesh.number_of_vertices(); const Edge e : mesh.edges()) {
    const Vec3 straight = 0.5 * (vec(mesh.point(mesh.vertex(e, 0))) + vec(mesh.point(mesh.vertex(e, 1))));
    farthest = std::max(farthest, (vec(fine.point(Vertex(static_cast<Mesh::size_type>(k++)))) - straight).norm());
  }
  EXPECT_NEAR(farthest, 0.01, 1e-9);
}

TEST(Refine, OnlyCoarseSurfacesNeedIt) {
  shapes::Tube tube = shapes::straight(1.5, 6);
  EXPECT_TRUE(is_coarse(shapes::mesh_of(tube)));
  tube.edge = 0.1;
  EXPECT_FALSE(is_coarse(shapes::mesh_of(tube)));
}

} // namespace
