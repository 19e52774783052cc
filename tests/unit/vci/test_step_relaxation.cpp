// The damping of steps that alternate in direction, on invented iterations whose limits are known.
#include "vci/solver/step_relaxation.hpp"
#include <gtest/gtest.h>

namespace {

using namespace vci;

/// The step of a vertex at x is its rate times x. Without damping it converges to 0 only for rates between -2 and 0.
Vectors steps_of(const Vectors& x, const std::vector<double>& rate) {
  Vectors dx(x.size());
  for (std::size_t i = 0; i < x.size(); ++i)
    dx[i] = rate[i] * x[i];
  return dx;
}

/// The positions of 200 vertices after `steps` steps; vertex 7 has its own rate.
Vectors positions_after(int steps, double rate_of_one, double rate_of_others, bool damps) {
  Vectors x(200, Vec3(0.001, 0, 0)), last;
  x[7] = Vec3(0.1, 0.05, 0);
  std::vector<double> rate(x.size(), rate_of_others);
  rate[7] = rate_of_one;
  StepRelaxation relaxation;
  for (int step = 0; step < steps; ++step) {
    Vectors dx = steps_of(x, rate);
    if (damps)
      relaxation.damp(dx, last, dx[0].norm());
    for (std::size_t i = 0; i < x.size(); ++i)
      x[i] += dx[i];
    last = dx;
  }
  return x;
}

TEST(StepRelaxation, AVertexThatJumpsToAndFroForEverSettles) {
  EXPECT_NEAR(positions_after(40, -2, -0.2, false)[7].norm(), Vec3(0.1, 0.05, 0).norm(), 1e-12);
  EXPECT_LT(positions_after(40, -2, -0.2, true)[7].norm(), 1e-3);
  EXPECT_LT(positions_after(40, -3, -0.2, true)[7].norm(), 1e-3) << "even where its jumps would grow";
}

TEST(StepRelaxation, AllVerticesThatJumpSettleThoughNoneIsAnOutlier) {
  Vectors x = positions_after(40, -2, -2, true);
  EXPECT_LT(x[0].norm(), 1e-5);
}

TEST(StepRelaxation, TurnsThatDecayAreLeftAlone) {
  EXPECT_EQ(positions_after(12, -1.7, -1.7, true)[0], positions_after(12, -1.7, -1.7, false)[0]);
  EXPECT_NE(positions_after(12, -1.9, -1.9, true)[0], positions_after(12, -1.9, -1.9, false)[0]) << "a slow decay";
}

TEST(StepRelaxation, VerticesThatTurnBackOnceOrGoOnAreLeftAlone) {
  const Vectors last(200, Vec3(0.001, 0, 0));
  const Vectors there(200, Vec3(0.001, 0.0001, 0)), back(200, Vec3(-0.0005, 0, 0));
  StepRelaxation relaxation;
  for (const Vectors& step : {there, back, there}) {
    Vectors dx = step;
    relaxation.damp(dx, last, step[0].norm());
    EXPECT_EQ(dx, step);
  }
  Vectors first = back;
  first[3] *= 100;
  const Vectors as_solved = first;
  StepRelaxation().damp(first, {}, 0.0005);
  EXPECT_EQ(first, as_solved) << "no step before";
}

} // namespace
