// The engine used as a library: arrays in and out, and a procedure that runs step by step.
#include "tests/unit/vci/vessel.hpp"
#include "vci/vci.hpp"
#include <gtest/gtest.h>

using namespace vci;

namespace {

Scene two_balloons() {
  Scene scene;
  scene.balloons["b"] = BalloonSpec{2.5, 6, 1.2, 0.9, 18, {4, 8, 12, 18}, {2.4, 2.5, 2.55, 2.6}};
  scene.procedure = {{"first", Action::predilatation, {{"b", "main", 10, 6}}},
                     {"second", Action::postdilatation, {{"b", "main", 10, 12}}}};
  scene.numerics.device_edge = 0.8;
  return scene;
}

TEST(Arrays, GiveTheLumenTheyCameFrom) {
  const Lumen whole = tests::Vessel().lumen();
  TriangleRows triangles(static_cast<Eigen::Index>(whole.triangles.size()), 3);
  for (std::size_t k = 0; k < whole.triangles.size(); ++k)
    for (int c = 0; c < 3; ++c)
      triangles(static_cast<Eigen::Index>(k), c) = whole.triangles[k][c];
  const PointRows points = rows_of(whole.points);
  const Lumen lumen = lumen_from(points, triangles, whole.radius);
  EXPECT_EQ(lumen.points, whole.points);
  EXPECT_EQ(lumen.triangles, whole.triangles);
  EXPECT_EQ(lumen.plaque, std::vector<double>(whole.points.size(), 0.0));
  EXPECT_THROW(lumen_from(points, triangles, {1.0}), common::InputError) << "a radius for each point";
  triangles(3, 1) = static_cast<int>(whole.points.size());
  EXPECT_THROW(lumen_from(points, triangles, whole.radius), common::InputError);
  PointRows broken = points;
  broken(0, 2) = std::numeric_limits<double>::quiet_NaN();
  triangles(3, 1) = 0;
  EXPECT_THROW(lumen_from(broken, triangles, whole.radius), common::InputError);
}

TEST(Deployment, TakenStepByStepEndsWhereAllAtOnceDoes) {
  const tests::Vessel vessel;
  Lumen lumen = vessel.lumen();
  lumen.plaque.assign(lumen.points.size(), 0.6); // fibrous plaque yields; a bare wall would spring back
  lumen.plaque_type.assign(lumen.points.size(), 1);
  const std::map<std::string, Path> paths{{"main", vessel.axis()}};
  const Scene scene = two_balloons();
  std::vector<std::string> lines;
  Observer observer;
  observer.log = [&](const std::string& line) { lines.push_back(line); };
  Deployment deployment(scene, lumen, paths, observer);
  EXPECT_EQ(deployment.lumen(), lumen.points);
  deployment.step();
  EXPECT_EQ(deployment.steps_done(), 1u);
  const auto throat = [&](const Vectors& points) {
    return smallest_section(points, lumen.triangles, paths.at("main"), 2, 18);
  };
  const double first = throat(deployment.lumen());
  EXPECT_GT(first, 1.1 * throat(lumen.points));
  EXPECT_FALSE(lines.empty());
  deployment.step();
  EXPECT_GE(throat(deployment.lumen()), first);
  EXPECT_THROW(deployment.step(), std::logic_error) << "none is left";
  const DeploymentResult whole = deploy(scene, lumen, paths);
  EXPECT_EQ(deployment.lumen(), whole.points) << "the same bits";
  EXPECT_EQ(deployment.result().stages.size(), whole.stages.size());
}

TEST(Deployment, GoesNoFurtherAfterAStepThatFailed) {
  const tests::Vessel vessel;
  Scene scene = two_balloons();
  scene.numerics.integrator.maximal_steps = 2;
  Deployment deployment(scene, vessel.lumen(), {{"main", vessel.axis()}});
  EXPECT_THROW(deployment.step(), common::ComputationError);
  EXPECT_THROW(deployment.step(), std::logic_error);
}

} // namespace
