// The limit on the compression of a triangle in one step.
#include "vci/solver/compression_limit.hpp"
#include "vci/solver/integrator.hpp"
#include <gtest/gtest.h>

namespace {

using namespace vci;

/// Two triangles that share an edge: a large one, and a small one on its right.
System two_triangles(const std::vector<char>& fixed = std::vector<char>(4, 0)) {
  System system;
  system.add_body("wall", {{0, 0, 0}, {0.4, -0.2, 0}, {0.4, 0.2, 0}, {0.5, 0, 0}}, {{0, 1, 2}, {1, 3, 2}}, 1e-3, fixed);
  return system;
}

/// Height of the small triangle above the shared edge after a step, mm; negative once it has turned over.
double height_after(const System& system, const Vectors& dx) {
  return (system.x[3] + dx[3] - 0.5 * (system.x[1] + dx[1] + system.x[2] + dx[2])).x();
}

TEST(CompressionLimit, AStepThatKeepsHalfOfEachLengthIsLeftAsItIs) {
  const System system = two_triangles();
  const Vectors wanted{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {-0.049, 0, 0}};
  Vectors dx = wanted;
  EXPECT_EQ(limit_compression(system, dx), 0);
  EXPECT_EQ(dx, wanted);
}

TEST(CompressionLimit, ACommonMotionATurnAndAWideningAreLeftAsTheyAre) {
  const System system = two_triangles();
  Vectors moved, turned, widened;
  for (const Vec3& x : system.x) {
    moved.push_back(Vec3(0.3, 0, 0.3));
    turned.push_back(Vec3(0.5 * x.x(), x.y(), 0.86 * x.x()) - x); // by 60 degrees about y
    widened.push_back(2 * x);
  }
  for (const Vectors& wanted : {moved, turned, widened}) {
    Vectors dx = wanted;
    EXPECT_EQ(limit_compression(system, dx), 0);
    EXPECT_EQ(dx, wanted);
  }
}

TEST(CompressionLimit, ASmallTriangleThatWouldCollapseOrTurnOverKeepsItsAreaAndItsMeanMotion) {
  const System system = two_triangles();
  for (double far : {-0.09, -0.1, -0.11, -0.2, -0.3}) { // the triangle is 0.1 mm high
    Vectors dx{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {far, 0, 0}};
    EXPECT_EQ(limit_compression(system, dx), 1) << far;
    EXPECT_GE(height_after(system, dx), 0.05 - 1e-12) << far;
    EXPECT_LT(height_after(system, dx), 0.1) << far << ": it still gives way";
    EXPECT_NEAR((dx[1] + dx[2] + dx[3]).x(), far, 1e-12);
    EXPECT_EQ(dx[0], Vec3(Vec3::Zero())) << "a vertex of no such triangle";
  }
}

TEST(CompressionLimit, AFixedVertexStays) {
  const System system = two_triangles({0, 1, 1, 0});
  Vectors dx{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {-0.2, 0, 0}};
  EXPECT_EQ(limit_compression(system, dx), 1);
  EXPECT_EQ(dx[1], Vec3(Vec3::Zero()));
  EXPECT_EQ(dx[2], Vec3(Vec3::Zero()));
  EXPECT_EQ(dx[3], Vec3(-0.05, 0, 0));
}

TEST(CompressionLimit, ATriangleWithoutAreaHoldsNothingBack) {
  System system;
  system.add_body("wall", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}, 1e-3, {0, 0, 0});
  const Vectors wanted{{0, 0, 0}, {0, 0.1, 0}, {0, 0, 0}};
  Vectors dx = wanted;
  EXPECT_EQ(limit_compression(system, dx), 0);
  EXPECT_EQ(dx, wanted);
}

/// A constant force in N on vertex 3 along -x.
struct Push : Force {
  explicit Push(double newton) : size(newton) {}
  ForceKind kind() const override { return ForceKind::pressure; }
  double energy(const Vectors& x) const override { return size * x[3].x(); }
  void evaluate(const Vectors&, Vectors& force, BlockMatrix*, bool) const override { force[3].x() -= size; }
  void declare_stencils(BlockPattern&) const override {}
  void locate_blocks(const BlockMatrix&) override {}
  double size;
};

TEST(CompressionLimit, HoldsInTheSolversSteps) {
  System system = two_triangles({1, 1, 1, 0});
  IntegratorSettings settings;
  settings.maximal_steps = 1;
  const double h = settings.initial_step;
  const double resistance = system.mass[3] / (h * h) + settings.damping * system.area[3] / h; // N/mm, of the first step
  system.add_force(0, std::make_unique<Push>(0.15 * resistance)); // 0.15 mm: past the shared edge, 0.1 mm away
  Interactions none;
  relax(system, none, settings);
  EXPECT_NEAR(system.x[3].x(), 0.4625, 1e-6) << "a quarter of the displacement, the largest share that keeps half";
}

} // namespace
