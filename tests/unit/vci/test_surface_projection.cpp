// Surface projection along interpolated normals: it tries every candidate triangle, and a sharp fold causes no jump.
#include "vci/contact/surface_projection.hpp"
#include "vci/geometry/surface.hpp"
#include <cmath>
#include <gtest/gtest.h>

namespace {

using namespace vci;

Vectors unit_normals_of(const System& system) {
  const Body& body = system.body(0);
  Vectors unit_normals = vertex_area_vectors(body.triangles, system.x, body.first, body.count);
  for (Vec3& n : unit_normals)
    n.normalize();
  return unit_normals;
}

TEST(SurfaceProjection, LooksAtEveryCandidate) {
  constexpr int around = 24; // triangles in a flat fan; the point is above the last
  Vectors points{Vec3::Zero()};
  Triangles triangles;
  for (int k = 0; k < around; ++k) {
    points.push_back({0.3 * std::cos(2 * pi * k / around), 0.3 * std::sin(2 * pi * k / around), 0});
    triangles.push_back({0, 1 + k, 1 + (k + 1) % around});
  }
  System system;
  system.add_body("fan", points, triangles, 1, std::vector<char>(points.size(), 0));
  std::vector<int> candidates;
  for (int k = 0; k < around; ++k)
    candidates.push_back(k);
  const double angle = 2 * pi * (around - 0.5) / around;
  double distance = 0;
  const SurfaceProjection found = project_onto({0.04 * std::cos(angle), 0.04 * std::sin(angle), 0.01}, candidates,
                                               system, unit_normals_of(system), system.body(0), distance);
  EXPECT_EQ(found.triangle, around - 1);
  EXPECT_TRUE(found.along_normals);
  EXPECT_NEAR(distance, 0.01, 1e-12);
}

/// A long, narrow triangle of a stretched wall. The normals of its corners differ by up to 56 degrees. A vertex 0.07 mm
/// above it had two projections in turn if the weights were only put into their own equation again and again. The
/// places are those of a stent's opening in calcium round 270 degrees.
TEST(SurfaceProjection, LiesOnTheNormalOfANarrowTriangle) {
  System system;
  system.add_body("narrow",
                  {{0.278708184, -1.29297587, 14.7597178},
                   {1.64146788, -0.79286867, 14.7816468},
                   {1.64032429, -0.852299084, 14.8386898}},
                  {{0, 1, 2}}, 1, std::vector<char>(3, 0));
  const Vectors unit_normals{{0.227043595, -0.939255729, -0.257390523},
                             {0.858131277, -0.376248154, -0.349353743},
                             {0.437161487, -0.822526428, 0.363785803}};
  const Vec3 p{1.19409081, -1.0783662, 14.786924};
  SurfaceProjection found;
  ASSERT_TRUE(follow_projection(p, 0, system, unit_normals, system.body(0), found));
  EXPECT_TRUE(found.along_normals);
  Vec3 q = Vec3::Zero();
  for (int k = 0; k < 3; ++k)
    q += found.weights[k] * system.x[k];
  const Vec3 n = interpolated_normal(system.body(0).triangles[0], found.weights, unit_normals);
  EXPECT_LT((p - q).cross(n).norm(), 1e-6) << "mm beside the normal";
}

/// Two triangles that meet in a sharp ridge along y, one of them nearly upright.
System ridge() {
  System system;
  system.add_body("ridge", {{0, -0.2, 0}, {0, 0.2, 0}, {-0.4, 0, 0.05}, {-0.05, 0, -0.4}}, {{0, 1, 2}, {1, 0, 3}}, 1,
                  std::vector<char>(4, 0));
  return system;
}

TEST(SurfaceProjection, PassesAnEdgeWithoutAJump) {
  const System system = ridge();
  const Vectors unit_normals = unit_normals_of(system);
  const Body& body = system.body(0);
  const Vec3 n = interpolated_normal(body.triangles[0], {0.5, 0.5, 0}, unit_normals), across = n.cross(Vec3::UnitY());
  const double out = across[0] > 0 ? 1 : -1; // the side beyond the edge
  SurfaceProjection before, beyond;
  ASSERT_TRUE(follow_projection(0.02 * n - 1e-4 * out * across, 0, system, unit_normals, body, before));
  EXPECT_TRUE(before.along_normals);
  const Vec3 past = 0.02 * n + 1e-4 * out * across;
  EXPECT_FALSE(follow_projection(past, 0, system, unit_normals, body, beyond));
  ASSERT_TRUE(project_onto_edge(past, 0, system, unit_normals, body, beyond));
  EXPECT_FALSE(beyond.along_normals);
  EXPECT_LT((beyond.weights - before.weights).norm(), 2e-3);
  EXPECT_FALSE(project_onto_edge(0.02 * n + 0.5 * out * across, 0, system, unit_normals, body, beyond))
      << "far from the edge";
}

} // namespace
