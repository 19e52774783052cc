// Some stiffness matrices neglect a term on purpose. The tests check that only the documented term is missing, and
// that it is bounded.
#include "force_checks.hpp"
#include "vci/bench/crimper.hpp"
#include "vci/devices/stent/cell_shear.hpp"
#include "vci/devices/stent/ring_hoop.hpp"
#include "vci/mechanics/fibre.hpp"
#include "vci/mechanics/hinge.hpp"
#include "vci/mechanics/pressure.hpp"
#include "vci/wall/foundation.hpp"
#include <Eigen/Dense>
#include <cmath>
#include <numeric>

namespace {

using namespace vci;
using namespace force_checks;
using Eigen::MatrixXd;

/// The smallest eigenvalue divided by the largest.
double least_curvature(const MatrixXd& k) {
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<MatrixXd>(k).eigenvalues();
  return values.minCoeff() / values.maxCoeff();
}

/// Minus the second derivative of the distance from vertex i to j, or of its logarithm, in a system of n vertices.
MatrixXd curvature_of_length(const Vectors& x, int i, int j, bool logarithm) {
  const auto gradient = [&](const Vectors& p) {
    Vectors g(p.size(), Vec3::Zero());
    const Vec3 d = p[j] - p[i];
    g[j] = logarithm ? Vec3(d / d.squaredNorm()) : d.normalized();
    g[i] = -g[j];
    return g;
  };
  return differences_of(gradient, x);
}

TEST(Hinges, MatrixLeavesOutOnlyHowTheAnglesGradientTurns) {
  const std::vector<InteriorEdge> edges = interior_edges(sheet_triangles, sheet);
  const InteriorEdge e = edges.at(0);
  const std::array<int, 4> places{e.e0, e.e1, e.w0, e.w1};
  const Vectors x = perturbed(sheet, 0.3, 3);
  const auto gradient = [&](const Vectors& p) {
    const Dihedral d = dihedral(p[e.e0], p[e.e1], p[e.w0], p[e.w1]);
    Vectors g(p.size());
    for (int k = 0; k < 4; ++k)
      g[places[k]] = d.gradient[k];
    return g;
  };
  const MatrixXd turn = differences_of(gradient, x);
  const double angle = dihedral(x[e.e0], x[e.e1], x[e.w0], x[e.w1]).angle;
  int bent = 0;
  for (double bend : {0.0, 0.05, 0.1, -0.1, 1.0}) { // rad from the rest angle; stents and balloons yield at 0.1
    Vectors rest = sheet;                           // will be bent so that x is this far from rest
    const Vec3 hinge = (rest[e.e1] - rest[e.e0]).normalized();
    const double first = dihedral(rest[e.e0], rest[e.e1], rest[e.w0], rest[e.w1]).angle;
    const auto turned = [&](double by) {
      Vectors p = rest;
      p[e.w1] = p[e.e0] + Eigen::AngleAxisd(by, hinge) * (rest[e.w1] - rest[e.e0]);
      return p;
    };
    const double by = angle - bend - first;
    const auto bend_of = [&](const Vectors& p) { return angle - dihedral(p[e.e0], p[e.e1], p[e.w0], p[e.w1]).angle; };
    rest = std::abs(bend_of(turned(by)) - bend) < 1e-9 ? turned(by) : turned(-by);
    ASSERT_NEAR(bend_of(rest), bend, 1e-9);
    Hinges force(edges, rest, {0.7}, 1e9);
    check_gradient(force, x);
    const MatrixXd matrix = stiffness_of(force, x), whole = stiffness_by_differences(force, x);
    // The force is -c * bend * g with c = 0.7. The matrix leaves out the derivative of the gradient g.
    EXPECT_LT(share(whole - matrix + 0.7 * bend * turn, matrix), 1e-6) << bend;
    EXPECT_LT(share(whole - matrix, matrix), 1.0 * std::abs(bend) + 1e-6) << bend;
    EXPECT_GT(least_curvature(matrix), -1e-12);
    if (std::abs(bend) > 0.01) {
      EXPECT_GT(share(whole - matrix, matrix), 0.1 * std::abs(bend)) << "what is left out must be there to be a test";
      ++bent;
    }
  }
  EXPECT_EQ(bent, 4);
}

TEST(CellShear, MatrixLeavesOutOnlyHowTheDiagonalsTurn) {
  CellShear force({{{0, 1, 2, 3}, 0.7}});
  const Vectors square{{0, 0, 0}, {1, 0, 0}, {1, 0.8, 0}, {0, 0.8, 0}};
  const Vectors x = perturbed(square, 0.2, 5);
  const double difference = (x[2] - x[0]).norm() - (x[3] - x[1]).norm();
  ASSERT_GT(std::abs(difference), 0.05);
  const MatrixXd matrix = stiffness_of(force, x), whole = stiffness_by_differences(force, x);
  const MatrixXd turn = curvature_of_length(x, 0, 2, false) - curvature_of_length(x, 1, 3, false);
  EXPECT_LT(share(whole - matrix + 0.7 * difference * turn, matrix), 1e-6);
  EXPECT_LT(share(whole - matrix, matrix), 1.1 * std::abs(difference));
  EXPECT_GT(share(whole - matrix, matrix), 0.1 * std::abs(difference));
  EXPECT_GT(least_curvature(matrix), -1e-12);
}

constexpr int around = 8;

Vectors ring(double jitter, unsigned seed) {
  Vectors x;
  for (int k = 0; k < around; ++k)
    x.push_back({std::cos(2 * pi * k / around), std::sin(2 * pi * k / around), 0});
  return perturbed(x, jitter, seed);
}

std::vector<int> ring_vertices() {
  std::vector<int> v(around);
  std::iota(v.begin(), v.end(), 0);
  return v;
}

TEST(RingEvenness, MatrixIsExactOnAnEvenRingAndLeavesOutOnlyHowEdgesTurn) {
  constexpr double c = 0.3;
  RingEvenness force({{ring_vertices(), c}});
  check_hessian(force, ring(0, 1));
  const Vectors x = ring(0.1, 1);
  check_gradient(force, x);
  MatrixXd left_out = MatrixXd::Zero(3 * around, 3 * around);
  double largest = 0;
  for (int k = 0; k < around; ++k) {
    const int i = k, j = (k + 1) % around, l = (k + 2) % around;
    const double ratio = std::log((x[j] - x[i]).norm() / (x[l] - x[j]).norm());
    left_out += c * ratio * (curvature_of_length(x, i, j, true) - curvature_of_length(x, j, l, true));
    largest = std::max(largest, std::abs(ratio));
  }
  ASSERT_GT(largest, 0.1);
  const MatrixXd matrix = stiffness_of(force, x), whole = stiffness_by_differences(force, x);
  EXPECT_LT(share(whole - matrix + left_out, matrix), 1e-6);
  EXPECT_LT(share(whole - matrix, matrix), 0.5 * largest);
  EXPECT_GT(share(whole - matrix, matrix), 0.1 * largest);
  EXPECT_GT(least_curvature(matrix), -1e-12);
}

TEST(RingHoops, MatrixOfAPressedRingLeavesOutOnlyWhatBucklesIt) {
  const Vectors x = ring(0.05, 2);
  double length = 0;
  for (int k = 0; k < around; ++k)
    length += (x[(k + 1) % around] - x[k]).norm();
  int plastic = 0;
  for (double strain : {-0.01, -0.1}) {
    RingHoops force({{ring_vertices(), 5.0, 0.03, 0.1, length / (1 + strain)}});
    plastic += force.count_yielding(x);
    const double tension = strain > -0.03 ? 5.0 * strain : -5.0 * (0.03 + 0.1 * (-strain - 0.03));
    MatrixXd left_out = MatrixXd::Zero(3 * around, 3 * around);
    for (int k = 0; k < around; ++k)
      left_out -= tension * curvature_of_length(x, k, (k + 1) % around, false);
    const MatrixXd matrix = stiffness_of(force, x), whole = stiffness_by_differences(force, x);
    EXPECT_LT(share(whole - matrix - left_out, whole), 1e-6) << strain;
    EXPECT_GT(share(left_out, whole), 1e-3) << strain;
    EXPECT_LT(Eigen::SelfAdjointEigenSolver<MatrixXd>(left_out).eigenvalues().maxCoeff(), 1e-8);
    EXPECT_GT(least_curvature(matrix), -1e-12);
  }
  EXPECT_EQ(plastic, 1);
}

/// A tube of three rings; the middle one has a foundation.
struct Tube {
  Vectors x;
  Triangles triangles;
  std::vector<RingFoundation::Element> middle;
  explicit Tube(const RingLaw& law) {
    for (int r = 0; r < 3; ++r)
      for (int k = 0; k < around; ++k)
        x.push_back({std::cos(2 * pi * k / around), std::sin(2 * pi * k / around), 0.5 * r});
    for (int r = 0; r < 2; ++r)
      for (int k = 0; k < around; ++k) {
        const int a = r * around + k, b = r * around + (k + 1) % around;
        triangles.insert(triangles.end(), {{a, b, b + around}, {a, b + around, a + around}});
      }
    for (int v = around; v < 2 * around; ++v)
      middle.push_back({v, x[v], Vec3(x[v][0], x[v][1], 0), 0.1, law});
  }
};

TEST(RingFoundation, MatrixLeavesOutOnlyHowTheSurfacesNormalsTurn) {
  const RingLaw law{0.055, 0.02, 0.012, 1.0, 1.2};
  const Tube tube(law);
  RingFoundation force(tube.middle, tube.triangles);
  EXPECT_LT(share(stiffness_of(force, tube.x) - stiffness_by_differences(force, tube.x), stiffness_of(force, tube.x)),
            1e-6)
      << "exact where there is no pressure";
  for (double opening : {0.1, 0.4, -0.2}) {
    Vectors x = tube.x;
    for (Vec3& p : x)
      p.head<2>() *= 1 + opening;
    // The force of the pressure along the surface's normals minus that along the reference normals.
    const auto off_the_reference = [&](const Vectors& p) {
      const Vectors normals = vertex_area_vectors(tube.triangles, p, 0, static_cast<int>(p.size()));
      Vectors f(p.size(), Vec3::Zero());
      for (const auto& e : tube.middle)
        f[e.vertex] = -e.area * law.pressure_and_slope((p[e.vertex] - e.origin).dot(e.normal))[0] *
                      (normals[e.vertex].normalized() - e.normal);
      return f;
    };
    const MatrixXd matrix = stiffness_of(force, x), whole = stiffness_by_differences(force, x);
    const MatrixXd turn = differences_of(off_the_reference, x);
    EXPECT_LT(share(whole - matrix - turn, matrix), 1e-6) << opening;
    EXPECT_GT(share(turn, matrix), 0.05) << opening;
    EXPECT_LT(share(turn, matrix), 0.25) << opening;
  }
}

TEST(RingFoundation, MatrixIsNeverNegativeWhereThePrestressIs) {
  const RingLaw softens{0, 0.02, 0.5, 1.0, 1.2};
  const Vec3 n = Vec3::UnitX();
  RingFoundation force({{0, Vec3(1, 0, 0), n, 0.1, softens}});
  const Vectors x{{1.1, 0, 0}};
  ASSERT_LT(softens.pressure_and_slope(0.1)[1], 0);
  check_hessian(force, x);
  const MatrixXd exact = stiffness_of(force, x), positive = stiffness_of(force, x, false);
  EXPECT_LT(exact(0, 0), 0);
  EXPECT_EQ(positive(0, 0), 0);
  EXPECT_NEAR(positive(1, 1), exact(1, 1), 1e-15);
}

TEST(Crimper, PressesOutsideItsRadiusOnlyAndMatchesFiniteDifferences) {
  Crimper force({0, 1}, 7.0);
  const Vectors x{{0.9, 0.7, 0.3}, {0.2, -0.5, 1}};
  const auto total = [&] { return force.total_force(x); };
  EXPECT_EQ(total(), 0) << "open";
  for (const auto& [radius, outside] : {std::pair{1.0, 1}, {0.4, 2}, {0.1, 2}}) {
    force.set_radius(radius);
    Vectors f(2, Vec3::Zero());
    force.evaluate(x, f, nullptr, true);
    EXPECT_EQ((f[0].norm() > 0) + (f[1].norm() > 0), outside);
    EXPECT_NEAR(total(), f[0].norm() + f[1].norm(), 1e-12);
    check_gradient(force, x);
    check_hessian(force, x);
  }
}

TEST(Pressure, MatrixLacksTheOpenEdgesAndHalfIsMeantToStayPositive) {
  const Tube tube({});
  Pressure force(tube.triangles, tube.x, 1.3);
  const Vectors x = perturbed(tube.x, 0.1, 4);
  const MatrixXd matrix = stiffness_of(force, x), whole = stiffness_by_differences(force, x);
  const std::vector<char> open = boundary_vertices(tube.triangles, static_cast<int>(x.size()));
  int exact = 0, lacking = 0;
  for (int i = 0; i < static_cast<int>(x.size()); ++i)
    for (int j = 0; j < static_cast<int>(x.size()); ++j) {
      const MatrixXd error = (matrix - whole).block<3, 3>(3 * i, 3 * j);
      if (open[i] && open[j]) {
        lacking += error.norm() > 1e-3;
      } else {
        EXPECT_LT(error.norm(), 1e-6) << i << ' ' << j;
        exact += whole.block<3, 3>(3 * i, 3 * j).norm() > 1e-3;
      }
    }
  EXPECT_GT(exact, 6 * around);
  EXPECT_EQ(lacking, 6 * around) << "each open edge both ways, and its two ends";
  EXPECT_LT(share(stiffness_of(force, x, false) - 0.5 * matrix, matrix), 1e-12);
}

TEST(Fibres, MatrixOfPressedOnesLeavesOutOnlyTheirNegativeParts) {
  const Vectors x{{0, 0, 0}, {1.0, 0.2, 0.1}};
  const double l = (x[1] - x[0]).norm();
  // The tension of a fibre falls beyond a stretch of e.
  Fibres pressed({{0, 1, l * 1.2, 3.0}}), stretched_far({{0, 1, l / 3.2, 3.0}});
  const MatrixXd buckles = stiffness_of(pressed, x) - stiffness_of(pressed, x, false);
  const MatrixXd falls = stiffness_of(stretched_far, x) - stiffness_of(stretched_far, x, false);
  for (const MatrixXd& left_out : {buckles, falls}) {
    EXPECT_LT(left_out.trace(), -0.01);
    EXPECT_LT(Eigen::SelfAdjointEigenSolver<MatrixXd>(left_out).eigenvalues().maxCoeff(), 1e-12);
  }
  EXPECT_GT(least_curvature(stiffness_of(pressed, x, false)), -1e-12);
  EXPECT_GT(least_curvature(stiffness_of(stretched_far, x, false)), -1e-12);
}

} // namespace
