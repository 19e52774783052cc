// Springs along triangles' edges and the shear stiffness of a stent's cells against finite differences.
#include "force_checks.hpp"
#include "vci/devices/stent/cell_shear.hpp"
#include "vci/wall/mass_spring.hpp"
#include <cmath>

namespace {

using namespace vci;
using namespace force_checks;

TEST(MassSpring, StiffeningAndYieldingSpringsMatchFiniteDifferences) {
  const HenckyLaw healthy{2.0, 0.45, 3.0}, plaque{2.0, 0.3, 0.0, 0.05, 0.08};
  HenckyLaw deep = plaque, deep_healthy = healthy;
  deep.depth = deep_healthy.depth = 0.7;
  const Vectors x = perturbed(sheet, 0.25, 1);
  for (SpringMapping mapping : {SpringMapping::lame, SpringMapping::van_gelder}) {
    MassSpring elastic(sheet_triangles, sheet, {healthy, deep_healthy}, mapping);
    MassSpring plastic(sheet_triangles, sheet, {plaque, deep}, mapping);
    EXPECT_EQ(elastic.count_yielding(x), 0);
    EXPECT_GE(plastic.count_yielding(x), 2) << "the plastic branch must be tested";
    for (MassSpring* force : {&elastic, &plastic}) {
      check_gradient(*force, x);
      check_hessian(*force, x);
    }
  }
}

TEST(MassSpring, LastingSetKeepsTheStressReached) {
  HenckyLaw plaque{2.0, 0.45, 0.0, 0.05, 0.1}, deep = plaque;
  deep.depth = 0.7;
  MassSpring force(sheet_triangles, sheet, {plaque, deep}, SpringMapping::lame);
  const Vectors x = perturbed(sheet, 0.3, 3);
  Vectors before(4, Vec3::Zero()), after = before, back = before;
  force.evaluate(x, before, nullptr, true);
  force.commit(x);
  force.evaluate(x, after, nullptr, true);
  for (int i = 0; i < 4; ++i)
    EXPECT_LT((after[i] - before[i]).norm(), 1e-12);
  force.evaluate(sheet, back, nullptr, true);
  EXPECT_GT(back[0].norm(), 0.1 * before[0].norm()) << "brought back, the springs press";
}

TEST(MassSpring, DampingIsCriticalAlongTheEdge) {
  const Vectors x{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  MassSpring force({{0, 1, 2}}, x, {{2.0, 0.45}}, SpringMapping::van_gelder);
  BlockPattern pattern(3);
  force.declare_stencils(pattern);
  BlockMatrix matrix(std::move(pattern));
  force.locate_blocks(matrix);
  force.add_damping(x, {0.1, 0.3, 0.2}, 5.0, matrix);
  const double k = 2.0 * 0.5; // E t A / L^2 of the edge 0-1
  EXPECT_NEAR(matrix.block(matrix.slot(0, 1))(0, 0), -5.0 * 2 * std::sqrt(k * 0.2), 1e-12);
  EXPECT_NEAR(matrix.block(matrix.slot(0, 1))(1, 1), 0, 1e-12) << "none across it";
}

TEST(CellShear, ResistsShearAndNothingElse) {
  CellShear force({{{0, 1, 2, 3}, 0.7}});
  const Vectors cell{{0, 0, 0}, {1, 0, 0}, {1, 0.8, 0}, {0, 0.8, 0}};
  Vectors opened = cell;
  for (Vec3& p : opened)
    p[0] *= 3;
  EXPECT_NEAR(force.energy(opened), 0, 1e-15);
  check_hessian(force, opened, 1e-6); // a Gauss-Newton matrix: exact where the diagonals are equally long
  check_gradient(force, perturbed(opened, 0.2, 5));
  EXPECT_GT(force.energy(perturbed(opened, 0.2, 5)), 1e-4);
}

} // namespace
