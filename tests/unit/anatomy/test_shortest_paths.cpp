#include "core/shortest_paths.hpp"
#include <gtest/gtest.h>
#include <random>

using namespace anatomy;

namespace {

TEST(ShortestPaths, OfAGraphWithAnIsland) {
  std::vector<CostGraph::Link> links;
  std::vector<double> costs;
  const auto link = [&](std::size_t a, std::size_t b, double cost) {
    links.insert(links.end(), {{a, b}, {b, a}});
    costs.insert(costs.end(), {cost, cost});
  };
  link(3, 0, 10); // not in the order of the nodes
  link(0, 1, 2);
  link(1, 2, 3);
  link(2, 3, 4);
  link(4, 5, 1);
  const ShortestPaths paths = CostGraph(6, links, costs).from(0);
  EXPECT_EQ(paths.cost, (std::vector<double>{0, 2, 5, 9, unreached, unreached}));
  EXPECT_EQ(paths.previous, (std::vector<std::size_t>{0, 0, 1, 2, 4, 5}));
}

TEST(ShortestPaths, NoLinkIsShorterThanTheDifference) {
  std::mt19937 random(1);
  std::uniform_int_distribution<std::size_t> node(0, 199);
  std::uniform_real_distribution<double> cost(0.1, 1);
  std::vector<CostGraph::Link> links;
  std::vector<double> costs;
  for (int k = 0; k < 800; ++k) {
    const std::size_t a = node(random), b = node(random);
    const double c = cost(random);
    links.insert(links.end(), {{a, b}, {b, a}});
    costs.insert(costs.end(), {c, c});
  }
  const ShortestPaths paths = CostGraph(200, links, costs).from(7);
  std::vector<double> tight(200, unreached); // for each node the least sum of a neighbour's cost and the link's cost
  for (std::size_t k = 0; k < links.size(); ++k)
    tight[links[k].second] = std::min(tight[links[k].second], paths.cost[links[k].first] + costs[k]);
  for (std::size_t i = 0; i < 200; ++i)
    if (i != 7 && paths.cost[i] < unreached) {
      EXPECT_DOUBLE_EQ(paths.cost[i], tight[i]);
    }
}

} // namespace
