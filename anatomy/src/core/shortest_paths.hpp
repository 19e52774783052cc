// Cheapest paths from one node of a graph to all others, by Dijkstra's algorithm (Boost.Graph).
#pragma once
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <vector>

namespace anatomy {

constexpr double unreached = 1e300; ///< cost of a node that no path reaches

/// The cheapest paths from one start node to all nodes.
struct ShortestPaths {
  std::vector<double> cost; ///< cost of the cheapest path to each node; `unreached` if there is none
  /// For each node, the node before it on its path. For the start node and an unreached node it is the node itself.
  std::vector<std::size_t> previous;
};

/// A graph whose edges have costs.
class CostGraph {
public:
  using Link = std::pair<std::size_t, std::size_t>;

  /// `nodes` is the number of nodes. `links` lists both directions of an edge separately. `costs` has a value for each
  /// link, at least 0.
  CostGraph(std::size_t nodes, const std::vector<Link>& links, const std::vector<double>& costs);
  ShortestPaths from(std::size_t start) const;

private:
  struct Cost {
    double value = 0;
  };
  boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, Cost> graph_;
};

} // namespace anatomy
