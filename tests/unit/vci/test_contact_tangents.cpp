// Contact between surfaces: energy, force and stiffness matrix of all contacts together agree.
// Within a step, the normals, weights and areas of the contacts are kept constant. They do not change when flat bodies
// approach one another, so there the matrix must be exact, on each branch of the law. For other bodies a bound of the
// neglected part is checked.
#include "contact_checks.hpp"
#include <map>

namespace {

using namespace vci;
using namespace contact_checks;

/// A wall in z = 0 and a device below it (nested) or above it (beside). The device's triangles are smaller, so that its
/// vertices do not lie over the wall's. On one side it reaches beyond the wall's edge, and it covers a window of the
/// wall.
struct SheetPair {
  System system;
  ContactScope sides;
  ContactSettings settings;
  Vectors gap_direction; ///< displacement of the device per mm of gap: along z, away from the wall
  explicit SheetPair(bool nested) {
    add_sheet(system, 8, 0.5, {0, 0, 0}, true);
    add_sheet(system, 9, 0.41, {-0.85, 0.133, 0}, nested);
    sides.nested = nested;
    sides.outer_excluded.assign(64, 0);
    for (int v : {4 * 8 + 3, 4 * 8 + 4, 4 * 8 + 5, 2 * 8 + 6, 6 * 8 + 2})
      sides.outer_excluded[v] = 1;
    gap_direction.assign(system.x.size(), Vec3::Zero());
    for (int v = 64; v < system.vertices(); ++v)
      gap_direction[v][2] = nested ? -1 : 1;
  }
  std::vector<ContactPoint> at(double gap, SurfaceContact& contact) {
    for (int v = 64; v < system.vertices(); ++v)
      system.x[v][2] = gap * gap_direction[v][2];
    std::vector<ContactPoint> points;
    contact.detect(system, area_vectors(system), points);
    return points;
  }
  Vectors force(double gap, SurfaceContact& contact) {
    Vectors f(system.x.size(), Vec3::Zero());
    add_contact_forces(at(gap, contact), f);
    return f;
  }
  /// The fade of a contact: the share of the surface at the projection that belongs neither to an end nor to a window.
  /// It is computed here from the flags of the vertices, independently of the tested code.
  ContactFade fade_of(const ContactPoint& p) const {
    const Body& target = system.body(p.stencil.vertex[0] < 64 ? 1 : 0);
    double ends = 1, windows = 1, both = 1;
    for (int k = 1; k < 4; ++k) {
      const int v = p.stencil.vertex[k];
      const double w = std::abs(p.stencil.weight[k]);
      const bool end = target.boundary[v - target.first], window = v < 64 && sides.outer_excluded[v];
      ends -= end ? w : 0;
      windows -= window ? w : 0;
      both -= end || window ? w : 0;
    }
    return {both, std::min(ends, 10 * windows)};
  }
};

TEST(SurfaceContact, ApproachMatchesFiniteDifferencesOnEveryBranch) {
  std::map<std::string, int> fired;
  // gaps (mm) in the curved part and in the linear part of the first ramp, then of the deep ramp
  const std::array<std::pair<std::string, double>, 4> depths{
      {{"rise", 0.004}, {"line", -0.012}, {"deep rise", -0.03}, {"deep line", -0.1}}};
  for (bool nested : {true, false})
    for (bool smooth : {true, false})
      for (const auto& [name, gap] : depths) {
        SheetPair pair(nested);
        pair.settings.smooth = smooth;
        SurfaceContact follows(1, 0, pair.settings, pair.sides);
        EXPECT_EQ(norm(pair.force(0.1, follows)), 0) << "far, nothing touches";
        const double h = 1e-6;
        for (bool fresh : {true, false}) { // found by a new search, or followed from a gap of 0.1 mm
          const auto contact = [&] { return fresh ? SurfaceContact(1, 0, pair.settings, pair.sides) : follows; };
          SurfaceContact here = contact(), plus = contact(), minus = contact();
          const auto energy = [&](double g, double& area) {
            SurfaceContact c = contact();
            double sum = 0;
            area = 0;
            for (const ContactPoint& p : pair.at(g, c)) {
              const ContactFade fade = pair.fade_of(p);
              sum += p.area / fade.ordinary * penalty_response(p.gap, pair.settings, fade).energy;
              area += p.area;
            }
            return sum;
          };
          double area = 0, area_plus = 0, area_minus = 0;
          energy(gap, area);
          const double slope = (energy(gap + h, area_plus) - energy(gap - h, area_minus)) / (2 * h);
          const Vectors up = pair.force(gap + h, plus), down = pair.force(gap - h, minus);
          const std::vector<ContactPoint> points = pair.at(gap, here);
          Vectors f(up.size(), Vec3::Zero());
          add_contact_forces(points, f);
          const Vectors predicted = predicted_change(stencils_of(points), pair.gap_direction);
          double along = 0;
          for (std::size_t v = 0; v < f.size(); ++v) {
            along += f[v].dot(pair.gap_direction[v]);
            EXPECT_LT(((up[v] - down[v]) / (2 * h) - predicted[v]).norm(), 1e-5 * norm(predicted)) << name << ' ' << v;
          }
          EXPECT_NEAR(area_plus, area, 1e-9);
          EXPECT_NEAR(along, -slope, 1e-6 * std::abs(slope)) << name;
          const double depth = pair.settings.distance - gap, ramps = depth / pair.settings.ramp;
          EXPECT_EQ(name, ramps < 1 ? "rise" : ramps < 1.5 ? "line" : ramps < 3.5 ? "deep rise" : "deep line");
          for (const ContactPoint& p : points) {
            const ContactFade fade = pair.fade_of(p);
            ++fired[name + (p.stencil.vertex[0] < 64 ? ", wall's vertex" : ", device's vertex")];
            fired["fades at an end"] += fade.ordinary < 1 && fade.ordinary == fade.deep;
            fired["fades at a window"] += fade.ordinary < 1 && fade.deep >= 1;
            fired["fades at a window, deep"] += fade.deep < 1 && fade.deep > fade.ordinary + 1e-9;
            EXPECT_NEAR(p.gap, gap, 1e-9);
          }
        }
      }
  for (const auto& [name, gap] : depths)
    for (const std::string who : {", wall's vertex", ", device's vertex"})
      EXPECT_GE(fired[name + who], 8 * 20) << name << who;
  EXPECT_GE(fired["fades at an end"], 32 * 8);
  EXPECT_GE(fired["fades at a window"], 32 * 3);
  EXPECT_GE(fired["fades at a window, deep"], 8);
}

TEST(SurfaceContact, FrictionsMatrixIsExactButAlongASlideAndForThePressuresPart) {
  SheetPair pair(true);
  const ContactSettings& s = pair.settings;
  const Vectors start = [&] {
    SurfaceContact any(1, 0, s, pair.sides);
    pair.at(-0.005, any);
    return pair.system.x;
  }();
  // force and stiffness at each vertex of the device, after it has moved by d since its contacts were found
  const auto moved = [&](const Vec3& d) {
    SurfaceContact contact(1, 0, s, pair.sides);
    pair.system.x = start;
    std::vector<ContactPoint> points, then;
    contact.detect(pair.system, area_vectors(pair.system), points);
    Vectors dx(start.size(), Vec3::Zero());
    for (int v = 64; v < pair.system.vertices(); ++v)
      dx[v] = d;
    add_slip(points, dx);
    pair.system.x = combined(start, 1, dx);
    contact.detect(pair.system, area_vectors(pair.system), then);
    // The fade changes with the projection. The matrix neglects this too, so contacts that fade are left out.
    std::erase_if(then,
                  [&](const ContactPoint& p) { return p.stencil.vertex[0] < 64 || pair.fade_of(p).ordinary < 1; });
    std::map<int, std::pair<Vec3, StencilStiffness>> by_vertex; // force on the vertex, stiffness
    for (const ContactPoint& p : then)
      by_vertex[p.stencil.vertex[0]] = {p.stencil.weight[0] * (p.force * p.stencil.normal + p.friction), p.stencil};
    return by_vertex;
  };
  const double pressure = penalty_response(-0.005, s).pressure,
               limit = s.friction * pressure / s.friction_stiffness; // mm
  const double h = 1e-7;
  int sticks = 0, slides = 0;
  for (double way : {0.5 * limit, 3 * limit}) {
    const Vec3 along = Vec3(0.6, 0.8, 0), across(-0.8, 0.6, 0), d = way * along;
    const auto here = moved(d);
    const auto slope = [&](int v, const Vec3& e) {
      return Vec3((moved(d + h * e).at(v).first - moved(d - h * e).at(v).first) / (2 * h));
    };
    for (const auto& [v, point] : here) {
      if (pair.system.body(1).boundary[v - 64] || v % 3 != 0)
        continue; // every third vertex is enough, since each takes a new search
      const Mat3 k = point.second.stiffness();
      const double size = point.second.tangential_stiffness;
      EXPECT_LT((slope(v, across) + k * across).norm(), 1e-4 * size) << v;
      if (way < limit) {
        ++sticks;
        EXPECT_LT((slope(v, along) + k * along).norm(), 1e-4 * size) << v;
      } else if (point.second.slip_softening.norm() > 0) {
        ++slides; // friction is constant along the slip; the matrix keeps 0.3 of the secant stiffness
        EXPECT_LT(slope(v, along).norm(), 1e-4 * size) << v;
        EXPECT_NEAR(along.dot(k * along), 0.3 * size, 1e-9);
      }
      // Moved deeper, the normal force changes as the matrix predicts. The friction limit changes by mu times as much;
      // the matrix neglects this change.
      const Vec3 left_out = slope(v, Vec3::UnitZ()) + k * Vec3::UnitZ();
      const double coupling = way < limit ? 0 : s.friction * point.second.normal_stiffness;
      EXPECT_NEAR(left_out.norm(), coupling, 1e-4 * point.second.normal_stiffness) << v;
    }
  }
  EXPECT_GE(sticks, 4);
  EXPECT_GE(slides, 4);
}

/// A tube about z whose vertices are moved at random, by up to 0.01 mm in each coordinate.
void add_tube(System& system, int around, double radius, double turn, unsigned seed) {
  Vectors points;
  Triangles triangles;
  constexpr int rings = 9;
  for (int r = 0; r < rings; ++r)
    for (int k = 0; k < around; ++k) {
      const double a = 2 * pi * k / around + turn;
      points.push_back({radius * std::cos(a), radius * std::sin(a), 0.6 * r});
    }
  for (int r = 0; r + 1 < rings; ++r)
    for (int k = 0; k < around; ++k) {
      const int a = r * around + k, b = r * around + (k + 1) % around;
      triangles.insert(triangles.end(), {{a, b, b + around}, {a, b + around, a + around}});
    }
  points = force_checks::perturbed(points, 0.01, seed);
  system.add_body("tube", points, triangles, 1, std::vector<char>(points.size(), 0));
}

/// The largest share, over six random displacements, of the change of the contact forces that the matrix does not
/// predict.
double unpredicted_share(double overlap, const ContactSettings& settings, int& touching) {
  System system;
  add_tube(system, 18, 1.5 - overlap, 0, 1);
  add_tube(system, 16, 1.5, 0.1, 2);
  const Vectors start = system.x;
  const auto force = [&](const Vectors& dx, std::vector<StencilStiffness>* links) {
    SurfaceContact contact(1, 0, settings);
    system.x = start;
    std::vector<ContactPoint> points, then;
    contact.detect(system, area_vectors(system), points);
    add_slip(points, dx);
    system.x = combined(start, 1, dx);
    contact.detect(system, area_vectors(system), then);
    Vectors f(start.size(), Vec3::Zero());
    add_contact_forces(then, f);
    if (links)
      *links = stencils_of(then);
    return f;
  };
  double worst = 0;
  const Vectors none(start.size(), Vec3::Zero());
  for (unsigned seed = 3; seed < 9; ++seed) {
    const Vectors d = force_checks::perturbed(none, 1, seed);
    std::vector<StencilStiffness> links;
    force(none, &links);
    touching = static_cast<int>(links.size());
    const double h = 1e-6;
    const Vectors change = combined(force(combined(none, h, d), nullptr), -1, force(combined(none, -h, d), nullptr));
    const Vectors predicted = predicted_change(links, d);
    worst = std::max(worst, norm(combined(predicted, -0.5 / h, change)) / norm(predicted));
  }
  return worst;
}

TEST(SurfaceContact, WhatHoldingNormalsAndWeightsLeavesOutIsATenthAtMost) {
  for (bool smooth : {true, false})
    for (double overlap : {-0.01, 0.0, 0.01, 0.05}) {
      ContactSettings settings;
      settings.smooth = smooth;
      int touching = 0;
      const double left_out = unpredicted_share(overlap, settings, touching);
      EXPECT_LT(left_out, 0.1) << overlap;
      EXPECT_GT(left_out, 0.01) << "tubes turn their normals: else this is no test of anything";
      EXPECT_GT(touching, 100);
    }
}

TEST(Tie, MatchesFiniteDifferencesInEveryDirection) {
  SheetPair pair(true);
  SurfaceContact contact(1, 0, pair.settings, pair.sides);
  std::vector<Tie> ties;
  std::vector<StencilStiffness> links;
  for (const ContactPoint& p : pair.at(-0.01, contact)) {
    ties.push_back(make_tie(p, pair.system.x, 60));
    links.push_back(ties.back().stencil);
  }
  ASSERT_GT(ties.size(), 40u);
  const auto energy = [&](const Vectors& x) {
    double sum = 0;
    for (const Tie& tie : ties) {
      Vec3 r = -tie.offset;
      for (int k = 0; k < 4; ++k)
        r += tie.stencil.weight[k] * x[tie.stencil.vertex[k]];
      sum += 0.5 * tie.stencil.normal_stiffness * r.squaredNorm() - tie.force * tie.stencil.normal.dot(r);
    }
    return sum;
  };
  const auto force = [&](const Vectors& x) {
    Vectors f(x.size(), Vec3::Zero());
    add_tie_forces(ties, x, f);
    return f;
  };
  const Vectors none(pair.system.x.size(), Vec3::Zero()), x = force_checks::perturbed(pair.system.x, 0.1, 1);
  for (unsigned seed = 2; seed < 8; ++seed) { // six random displacements
    const double h = 1e-6;
    const Vectors d = force_checks::perturbed(none, 1, seed), f = force(x), predicted = predicted_change(links, d);
    const Vectors change = combined(force(combined(x, h, d)), -1, force(combined(x, -h, d)));
    double along = 0;
    for (std::size_t v = 0; v < x.size(); ++v)
      along += f[v].dot(d[v]);
    EXPECT_NEAR(along, -(energy(combined(x, h, d)) - energy(combined(x, -h, d))) / (2 * h), 1e-5 * norm(f));
    EXPECT_LT(norm(combined(predicted, -0.5 / h, change)), 1e-6 * norm(predicted));
  }
}

} // namespace
