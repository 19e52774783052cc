// Cheapest ways from one node of an undirected graph to all others (Dijkstra's algorithm, Boost.Graph).
#pragma once
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <vector>

namespace anatomy {

constexpr double unreached = 1e300;

struct Ways {
  std::vector<double> cost;        ///< of the cheapest way to each node; unreached where there is none
  std::vector<std::size_t> before; ///< the node before it on that way; itself at the start and where there is none
};

class WayGraph {
public:
  using Link = std::pair<std::size_t, std::size_t>;

  /// `links` lists each direction of an edge of its own, `costs` (not negative) belongs to it.
  WayGraph(std::size_t nodes, const std::vector<Link>& links, const std::vector<double>& costs);
  Ways from(std::size_t start) const;

private:
  struct Cost {
    double value = 0;
  };
  boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, Cost> graph_;
};

} // namespace anatomy
