// Contact between layers of one body. Where flat layers approach one another, energy, force and stiffness matrix of all
// contacts agree exactly.
#include "contact_checks.hpp"
#include "vci/contact/self_contact.hpp"

namespace {

using namespace vci;
using namespace contact_checks;

/// Two layers of one body, the upper one `gap` over the lower one, with their outer or their inner faces to each other.
struct Layers {
  static constexpr double thickness = 0.05, stiffness = 30; // mm; MPa/mm, for the vertices of one layer
  System system;
  Vectors gap_direction;
  explicit Layers(bool outer_faces) {
    System two;
    add_sheet(two, 7, 0.1, {0, 0, 0}, outer_faces);
    add_sheet(two, 6, 0.11, {0.03, 0.021, 0.1}, !outer_faces);
    Triangles all = two.body(0).triangles;
    all.insert(all.end(), two.body(1).triangles.begin(), two.body(1).triangles.end());
    system.add_body("balloon", two.x, all, 1, std::vector<char>(two.x.size(), 0));
    gap_direction.assign(two.x.size(), Vec3::Zero());
    for (int v = 49; v < two.vertices(); ++v)
      gap_direction[v] = Vec3::UnitZ();
  }
  std::vector<ContactPoint> at(double gap, SelfContact& contact) {
    for (int v = 49; v < system.vertices(); ++v)
      system.x[v][2] = gap;
    std::vector<ContactPoint> points;
    contact.detect(system, area_vectors(system), points);
    return points;
  }
};

TEST(SelfContact, ApproachMatchesFiniteDifferencesOnEveryBranch) {
  int through = 0;
  for (bool outer_faces : {true, false}) {
    Layers layers(outer_faces);
    SelfContact contact(layers.system, 0, 2 * Layers::stiffness, std::vector<double>(85, Layers::thickness));
    EXPECT_TRUE(layers.at(0.1, contact).empty());
    EXPECT_GT(contact.count_facing(), 60) << "layers are faced before they touch";
    const auto force = [&](double gap) {
      Vectors f(85, Vec3::Zero());
      add_contact_forces(layers.at(gap, contact), f);
      return f;
    };
    EXPECT_EQ(norm(force(0.0451)), 0);
    // The gaps are in the curved part of the law, in its linear part, and in its linear part with one layer through the
    // other. No new search is made between them, because it would also find the crossed layer from its other side.
    for (const auto& [gap, law] : {std::pair{0.035, 0.5}, {0.01, 1.0}, {-0.006, 1.0}}) {
      constexpr double h = 1e-7, begins = 0.9 * Layers::thickness, width = 0.4 * Layers::thickness;
      const Vectors change = combined(force(gap + h), -1, force(gap - h)), f = force(gap);
      const std::vector<ContactPoint> points = layers.at(gap, contact);
      const Vectors predicted = predicted_change(stencils_of(points), layers.gap_direction);
      EXPECT_LT(norm(combined(predicted, -0.5 / h, change)), 1e-5 * norm(predicted)) << gap;
      // energy: the integral of the law from the gap at which contact begins
      const auto energy = [&](double g) {
        const double a = begins - g;
        double area = 0;
        for (const ContactPoint& p : points)
          area += p.area;
        return area * Layers::stiffness *
               (a < width ? a * a * a / (6 * width) : width * width / 6 + 0.5 * a * (a - width));
      };
      double along = 0, sum = 0;
      for (std::size_t v = 0; v < f.size(); ++v) {
        along += f[v].dot(layers.gap_direction[v]);
        sum += f[v][2];
      }
      EXPECT_NEAR(along, -(energy(gap + h) - energy(gap - h)) / (2 * h), 1e-5 * along);
      EXPECT_NEAR(sum, 0, 1e-12);
      for (const ContactPoint& p : points) {
        EXPECT_NEAR(p.stencil.normal_stiffness, law * Layers::stiffness * p.area, 1e-9);
        EXPECT_EQ(p.stencil.weight[0], outer_faces ? 1 : -1);
        through += p.gap < 0;
      }
      EXPECT_GT(points.size(), 60u);
    }
  }
  EXPECT_GT(through, 120);
}

} // namespace
