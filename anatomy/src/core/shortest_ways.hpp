// Cheapest ways from one node of an undirected graph to all others (Dijkstra's algorithm, Boost.Graph).
#pragma once
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <vector>

namespace anatomy {

constexpr double unreached = 1e300;

struct Ways {
  std::vector<double> cost;        ///< of the cheapest way to each node; `unreached` if there is none
  std::vector<std::size_t> before; ///< the previous node on this way; the node itself at the start and if unreached
};

class WayGraph {
public:
  using Link = std::pair<std::size_t, std::size_t>;

  /// `links` lists both directions of an edge separately; `costs` (not negative) has a value for each.
  WayGraph(std::size_t nodes, const std::vector<Link>& links, const std::vector<double>& costs);
  Ways from(std::size_t start) const;

private:
  struct Cost {
    double value = 0;
  };
  boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, Cost> graph_;
};

} // namespace anatomy
