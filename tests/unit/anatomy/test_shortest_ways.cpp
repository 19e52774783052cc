#include "core/shortest_ways.hpp"
#include <gtest/gtest.h>
#include <random>

using namespace anatomy;

namespace {

TEST(ShortestWays, OfAGraphWithAnIsland) {
  std::vector<WayGraph::Link> links;
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
  const Ways ways = WayGraph(6, links, costs).from(0);
  EXPECT_EQ(ways.cost, (std::vector<double>{0, 2, 5, 9, unreached, unreached}));
  EXPECT_EQ(ways.before, (std::vector<std::size_t>{0, 0, 1, 2, 4, 5}));
}

TEST(ShortestWays, NoLinkIsShorterThanTheDifference) {
  std::mt19937 random(1);
  std::uniform_int_distribution<std::size_t> node(0, 199);
  std::uniform_real_distribution<double> cost(0.1, 1);
  std::vector<WayGraph::Link> links;
  std::vector<double> costs;
  for (int k = 0; k < 800; ++k) {
    const std::size_t a = node(random), b = node(random);
    const double c = cost(random);
    links.insert(links.end(), {{a, b}, {b, a}});
    costs.insert(costs.end(), {c, c});
  }
  const Ways ways = WayGraph(200, links, costs).from(7);
  std::vector<double> tight(200, unreached); // least cost + link over the links that end in a node
  for (std::size_t k = 0; k < links.size(); ++k)
    tight[links[k].second] = std::min(tight[links[k].second], ways.cost[links[k].first] + costs[k]);
  for (std::size_t i = 0; i < 200; ++i)
    if (i != 7 && ways.cost[i] < unreached) {
      EXPECT_DOUBLE_EQ(ways.cost[i], tight[i]);
    }
}

} // namespace
