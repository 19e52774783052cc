// The tissue between two branches: its law, its stiffness, and where it is.
#include "force_checks.hpp"
#include "vci/wall/septum.hpp"

namespace {

using namespace vci;
using namespace force_checks;

constexpr double poisson_ratio = 0.45;

Septum single_element(const Vectors& reference) {
  Mat3 edges;
  for (int k = 0; k < 3; ++k)
    edges.col(k) = reference[k + 1] - reference[0];
  return Septum({{{0, 1, 2, 3}, edges.inverse(), 0.7, 0.8}}, poisson_ratio);
}

TEST(Septum, MatchesFiniteDifferences) {
  Septum septum = single_element(tetrahedron);
  const Vectors x = perturbed(tetrahedron, 0.2, 1);
  check_gradient(septum, x);
  check_hessian(septum, x);
}

TEST(Septum, MatchesFiniteDifferencesWhereItIsThinOrInsideOut) {
  for (double height : {0.1, -0.3}) {
    Vectors x = tetrahedron;
    x[3][2] = height;
    x = perturbed(x, 0.05, 2);
    Septum septum = single_element(tetrahedron);
    check_gradient(septum, x);
    check_hessian(septum, x);
  }
}

TEST(Septum, TheSolversMatrixHasNoNegativeEigenvalues) {
  for (double height : {1.4, 0.5, 0.1, -0.3}) {
    Vectors x = tetrahedron;
    x[3][2] = height;
    Septum septum = single_element(tetrahedron);
    const Eigen::MatrixXd matrix = stiffness_of(septum, perturbed(x, 0.05, 3), false);
    const Eigen::VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix).eigenvalues();
    EXPECT_GT(eigenvalues.minCoeff(), -1e-12 * eigenvalues.maxCoeff());
  }
}

TEST(Septum, ARotationCausesNoForce) {
  Septum septum = single_element(tetrahedron);
  const Mat3 rotation = Eigen::AngleAxisd(1.1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  Vectors x = tetrahedron, force(4, Vec3::Zero());
  for (Vec3& p : x)
    p = rotation * p + Vec3(3, -1, 2);
  septum.evaluate(x, force, nullptr, false);
  for (const Vec3& f : force)
    EXPECT_LT(f.norm(), 1e-12);
}

constexpr SeptumTissue tissue{0.6, 0.8, 0.08};

/// Two square plates of 2 mm, the walls of two branches. The lower one has its lumen below, the upper one above.
struct Plates {
  static constexpr int cells = 5;
  static constexpr double width = 2;
  Vectors points;
  Triangles triangles;
  std::vector<int> branch; ///< of each triangle: 0 below, 1 above

  explicit Plates(double distance) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> shift(-0.08, 0.08);
    for (int plate : {0, 1}) {
      const int first = static_cast<int>(points.size());
      for (int j = 0; j <= cells; ++j)
        for (int i = 0; i <= cells; ++i) {
          const bool inside = i > 0 && i < cells && j > 0 && j < cells;
          points.emplace_back(width * i / cells + (inside ? shift(random) : 0),
                              width * j / cells + (inside ? shift(random) : 0), plate * distance);
        }
      for (int j = 0; j < cells; ++j)
        for (int i = 0; i < cells; ++i) {
          const int a = first + j * (cells + 1) + i, b = a + 1, c = a + cells + 1, d = c + 1;
          triangles.push_back(plate == 0 ? Triangle{a, b, d} : Triangle{a, d, b});
          triangles.push_back(plate == 0 ? Triangle{a, d, c} : Triangle{a, c, d});
          branch.insert(branch.end(), 2, plate);
        }
    }
  }
  std::vector<Septum::Element> elements() const { return septum_elements(triangles, points, branch, tissue); }
  bool upper(std::size_t v) const { return v >= points.size() / 2; }
};

TEST(Septum, CompressedPlatesPushBackAsAConfinedSolid) {
  const double thickness = 1.1, stretch = 0.6; // no thicker than both walls, so the modulus is theirs
  const Plates plates(thickness);
  const Septum septum(plates.elements(), poisson_ratio);
  Vectors x = plates.points, force(x.size(), Vec3::Zero());
  for (Vec3& p : x)
    p[2] *= stretch;
  septum.evaluate(x, force, nullptr, false);
  Vec3 on_upper = Vec3::Zero(), on_lower = Vec3::Zero();
  for (std::size_t v = 0; v < x.size(); ++v)
    (plates.upper(v) ? on_upper : on_lower) += force[v];
  const double e = tissue.wall_modulus, mu = e / (2 * (1 + poisson_ratio)),
               lambda = e * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio));
  const double stress = mu * (stretch - 1 / stretch) + lambda * std::log(stretch) / stretch; // uniaxial strain
  EXPECT_NEAR(on_upper[2], -stress * Plates::width * Plates::width, 1e-12);
  EXPECT_NEAR((on_upper + on_lower).norm(), 0, 1e-12);
  EXPECT_GT(on_upper[2], 2.03 * Plates::width * Plates::width) << "less than the pressure of a balloon at 20 bar";
}

TEST(Septum, EveryVertexOfFacingPlatesHasAnElement) {
  const Plates plates(1.1);
  double volume = 0;
  const auto elements = plates.elements();
  for (const Septum::Element& e : elements)
    volume += e.volume;
  EXPECT_EQ(elements.size(), plates.points.size());
  EXPECT_NEAR(volume, 1.1 * Plates::width * Plates::width, 1e-12);
}

TEST(Septum, TissueBetweenTheWallsIsSofter) {
  EXPECT_DOUBLE_EQ(tissue.modulus(0.5), 0.8);
  EXPECT_DOUBLE_EQ(tissue.modulus(1.2), 0.8);
  EXPECT_DOUBLE_EQ(tissue.modulus(2.0), 2.0 / (1.2 / 0.8 + 0.8 / 0.08));
  const SeptumTissue no_tissue{0.6, 0.8, 0};
  EXPECT_DOUBLE_EQ(no_tissue.modulus(1.2), 0.8);
  EXPECT_DOUBLE_EQ(no_tissue.modulus(1.3), 0);
}

TEST(Septum, DistantBranchesHaveNone) {
  EXPECT_FALSE(Plates(2.9).elements().empty()) << "just near enough";
  EXPECT_TRUE(Plates(3.1).elements().empty());
  EXPECT_TRUE(Plates(-1).elements().empty()) << "a lumen between two walls";
}

TEST(Septum, BranchesThatTouchHaveNone) {
  EXPECT_TRUE(Plates(0).elements().empty()) << "an element without height has no inverse";
  EXPECT_FALSE(Plates(0.01).elements().empty());
}

TEST(Septum, ASingleBranchHasNone) {
  Plates plates(1.1); // facing walls of one branch may be the two shoulders of a steep lesion
  std::fill(plates.branch.begin(), plates.branch.end(), 7);
  EXPECT_TRUE(plates.elements().empty());
  plates.branch.clear();
  EXPECT_TRUE(plates.elements().empty());
}

} // namespace
