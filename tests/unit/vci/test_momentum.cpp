// The bodies of a deployment without any support from outside: forces within and between them sum to zero.
#include "contact_checks.hpp"
#include "straight_axis.hpp"
#include "vci/devices/balloon/balloon.hpp"
#include "vci/devices/stent/stent.hpp"
#include "vci/mechanics/hinge.hpp"
#include "vci/mechanics/membrane.hpp"
#include "vci/scene/numerics.hpp"
#include "vci/solver/integrator.hpp"
#include "vci/solver/textbook.hpp"
#include "vci/wall/foundation.hpp"
#include <Eigen/Geometry>

namespace {

using namespace vci;
using tests::straight_frames;
using namespace contact_checks;

/// A wall without foundation, a stent and a balloon without any support; all touch, and all are strained. The balloon
/// is under pressure, its tips closed by fans of triangles. Anchors of negative stiffness cancel the
/// anchors that hold the balloon to its shaft.
struct FreeSystem {
  System system;
  Interactions touching;
  int balloon = 0, balloon_ring_size = 0;
  explicit FreeSystem(bool closed = true) {
    const StentSpec stent{3.0, 8, 1.0, 4.4, 0.08, 8, 2, "b", 11, 0.5, 20, 0.22, 4.5};
    const BalloonSpec spec{3.0, 8.0, 1.0, 0.8, 16.0, {3, 7, 11, 16}, {2.73, 2.9, 3.0, 3.14}};
    Numerics numerics;
    RingGrid wall{20, {}, {}, {}}, rings = stent_grid(stent, 0.6), bag = balloon_grid(spec, 0.6);
    for (int r = 0; r < 24; ++r) {
      wall.s.push_back(0.5 * (r - 11.5));
      wall.profile.push_back(1);
    }
    const Vectors tube = place_grid(wall, straight_frames(wall), std::vector<double>(24, 1.5));
    const int w = system.add_body("wall", tube, wall.triangles(), 1e-3, std::vector<char>(tube.size(), 0));
    const Triangles triangles = system.body(w).triangles;
    const std::vector<InteriorEdge> edges = interior_edges(triangles, tube);
    system.add_force(
        w, std::make_unique<Membrane>(triangles, tube, std::vector<HenckyLaw>(triangles.size(), {0.16, 0.45, 3.0})));
    system.add_force(w, std::make_unique<Hinges>(edges, tube, std::vector<double>(edges.size(), 1e-3), 0.1));
    const Stent s =
        add_stent(system, stent, "stent", rings, straight_frames(rings), std::vector<double>(rings.rings(), 1.495));
    std::vector<double> radii;
    for (double profile : bag.profile)
      radii.push_back(1.49 * profile);
    balloon_ring_size = bag.ring_size;
    Balloon b = add_balloon(system, spec, bag, straight_frames(bag), radii);
    balloon = b.body;
    set_pressure(b, pressure);
    if (closed) {
      b.pressure->set(0);
      Triangles bag_and_caps = system.body(balloon).triangles;
      const int first = system.body(balloon).first, last = first + (bag.rings() - 1) * bag.ring_size;
      for (int k = 1; k + 1 < bag.ring_size; ++k) {
        bag_and_caps.push_back({first, first + k + 1, first + k});
        bag_and_caps.push_back({last, last + k, last + k + 1});
      }
      system.add_force(balloon, std::make_unique<Pressure>(bag_and_caps, system.x, pressure));
    }
    std::vector<Anchors::Element> off;
    for (int v = system.body(balloon).first; v < system.vertices(); ++v)
      if (system.body(balloon).boundary[v - system.body(balloon).first])
        off.push_back({v, system.x[v], -shaft_anchor});
    system.add_force(balloon, std::make_unique<Anchors>(off));
    system.x = force_checks::perturbed(system.x, 0.004, 7);
    touching.contacts.emplace_back(s.body, w, numerics.contact);
    touching.contacts.emplace_back(balloon, s.body, numerics.contact);
    touching.contacts.emplace_back(balloon, w, numerics.contact);
  }
  static constexpr double pressure = 0.8, shaft_anchor = 0.02; // MPa; N/mm, as balloon.cpp has it
};

/// The resultant of the forces and of their moments about the origin, each divided by the sum of the magnitudes.
std::array<double, 2> relative_resultants(const Vectors& f, const Vectors& x) {
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  double forces = 0, moments = 0;
  for (std::size_t i = 0; i < f.size(); ++i) {
    force += f[i];
    moment += x[i].cross(f[i]);
    forces += f[i].norm();
    moments += x[i].norm() * f[i].norm();
  }
  return {force.norm() / forces, moment.norm() / moments};
}

Vectors pressure_of(FreeSystem& free) {
  Vectors elastic, foundation, pressure;
  free.system.evaluate(elastic, foundation, pressure, false);
  return pressure;
}

TEST(Momentum, ForcesOfAFreeSystemSumToNothing) {
  FreeSystem free;
  System& system = free.system;
  Vectors elastic, foundation, pressure;
  system.evaluate(elastic, foundation, pressure, false);
  EXPECT_EQ(norm(foundation), 0);
  for (const Vectors* f : {&elastic, &pressure}) {
    EXPECT_GT(norm(*f), 1);
    EXPECT_LT(relative_resultants(*f, system.x)[0], 1e-14);
    EXPECT_LT(relative_resultants(*f, system.x)[1], 1e-14);
  }
}

TEST(Momentum, OfAnOpenBalloonTheShaftBearsThePressureOnItsTips) {
  FreeSystem closed, open(false);
  const Body& bag = open.system.body(open.balloon);
  Vec3 sum = Vec3::Zero(), tips = Vec3::Zero();
  for (const Vec3& f : pressure_of(open))
    sum += f;
  for (int tip : {bag.first, bag.first + bag.count - open.balloon_ring_size})
    for (int k = 0; k < open.balloon_ring_size; ++k) {
      const Vec3 &a = open.system.x[tip + k], &b = open.system.x[tip + (k + 1) % open.balloon_ring_size];
      tips += (tip == bag.first ? -0.5 : 0.5) * a.cross(b);
    }
  EXPECT_GT(tips.norm(), 1e-4) << "disturbed, they are not alike";
  EXPECT_LT((sum + FreeSystem::pressure * tips).norm(), 1e-13 * norm(pressure_of(open)));
  EXPECT_GT(norm(combined(pressure_of(closed), -1, pressure_of(open))), 0.01);
}

TEST(Momentum, ContactSumsToNothingAndTurnsByItsFrictionOverTheGapAlone) {
  FreeSystem free;
  System& system = free.system;
  std::vector<ContactPoint> points;
  free.touching.detect(system, area_vectors(system), points);
  Vectors turn(system.x.size(), Vec3::Zero());
  const Body& stent = system.body(1);
  for (int v = stent.first; v < stent.first + stent.count; ++v)
    turn[v] = 2e-3 * Vec3::UnitZ().cross(system.x[v]);
  for (const bool slid : {false, true}) {
    if (slid) {
      add_slip(points, turn);
      system.x = combined(system.x, 1, turn);
      points.clear();
      free.touching.detect(system, area_vectors(system), points);
    }
    Vectors f(system.x.size(), Vec3::Zero());
    add_contact_forces(points, f);
    EXPECT_GT(points.size(), 1000u);
    EXPECT_LT(relative_resultants(f, system.x)[0], 1e-14);
    // The normal forces of a contact point act along the line from the vertex to its projection, within the accuracy of
    // the projection, so they have no moment. The friction acts on both sides of the gap and forms a couple, which is
    // at most the friction coefficient times force times gap.
    Vec3 moment = Vec3::Zero(), couples = Vec3::Zero();
    double arms = 0, friction = 0;
    for (std::size_t i = 0; i < f.size(); ++i) {
      moment += system.x[i].cross(f[i]);
      arms += system.x[i].norm() * f[i].norm();
    }
    for (const ContactPoint& p : points) {
      Vec3 between = Vec3::Zero();
      for (int k = 0; k < 4; ++k)
        between += p.stencil.weight[k] * system.x[p.stencil.vertex[k]];
      couples += between.cross(p.friction);
      friction += p.friction.norm();
      EXPECT_LE(p.friction.norm(), 0.1 * p.force + 1e-12);
    }
    EXPECT_LT((moment - couples).norm(), 1e-9 * arms);
    EXPECT_EQ(couples.norm() > 1e-6 * arms, slid);
    EXPECT_EQ(friction > 0, slid);
  }
}

/// The linear momentum and the angular momentum about the origin after steps of h ms, each divided by the sum of its
/// parts' magnitudes, and the largest displacement in a step (mm). Momentum taken by damping is added back.
std::array<double, 3> momentum_after_steps(double h, int steps, bool textbook, double damping) {
  FreeSystem free;
  System& system = free.system;
  IntegratorSettings s;
  s.damping = damping;
  s.residual_tolerance = 1e-14;
  s.initial_step = s.maximal_step = s.fixed_step = h;
  s.displacement_per_step = 1;
  s.maximal_steps = steps;
  s.velocity_kept = 1;
  s.velocity_stop = 0;
  s.pcg = {1e-12, 5000, 0, false};
  const Vectors start = system.x;
  Vectors before = start, momentum = start;
  double largest = 0;
  free.touching.after_step = [&](int, const Balance&) {
    for (int i = 0; i < system.vertices(); ++i) {
      // damping against the surroundings has taken c A dx from each vertex
      momentum[i] = system.mass[i] * system.velocity[i] + damping * system.area[i] * (system.x[i] - start[i]);
      largest = std::max(largest, (system.x[i] - before[i]).norm());
    }
    before = system.x;
  };
  const RelaxResult result = textbook ? relax_textbook(system, free.touching, s) : relax(system, free.touching, s);
  EXPECT_EQ(result.steps, steps);
  const auto [linear, angular] = relative_resultants(momentum, system.x);
  return {linear, angular, largest};
}

TEST(Textbook, MeasuringTheBalanceStiffensNoDeepContact) {
  std::vector<double> residuals;
  for (const double limit : {1e-9, 1e9}) { // mm: penetration above which relax() stiffens a contact
    FreeSystem free;
    IntegratorSettings s;
    s.fixed_step = 1e-3;
    s.maximal_steps = 1;
    s.maximal_penetration = limit;
    const RelaxResult result = relax_textbook(free.system, free.touching, s);
    EXPECT_GT(result.maximal_penetration, 1e-6);
    residuals.push_back(result.residual);
  }
  EXPECT_EQ(residuals[0], residuals[1]);
}

TEST(Momentum, IsKeptOverStepsToTheLinearSolvesTolerance) {
  for (const auto& [textbook, damping] : {std::pair{true, 0.0}, {false, 0.0}, {false, 2.5}}) {
    const auto [linear, angular, largest] = momentum_after_steps(0.03, 6, textbook, damping);
    EXPECT_LT(linear, 1e-9) << textbook << damping;
    EXPECT_GT(largest, 0.01);
    EXPECT_LT(largest, 1.5) << "a vertex held back takes its momentum along";
  }
}

TEST(Momentum, AngularOneIsKeptAsStepsBecomeShort) {
  // A linear step turns bodies along tangents, which adds angular momentum in proportion to the step's length.
  const auto coarse = momentum_after_steps(0.01, 4, true, 0), fine = momentum_after_steps(0.0025, 16, true, 0);
  EXPECT_LT(fine[1], 0.5 * coarse[1]);
  EXPECT_LT(coarse[1], 2e-3);
}

} // namespace
