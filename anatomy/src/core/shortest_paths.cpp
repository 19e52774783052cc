#include "core/shortest_paths.hpp"
#include <boost/graph/dijkstra_shortest_paths.hpp>

namespace anatomy {

CostGraph::CostGraph(std::size_t nodes, const std::vector<Link>& links, const std::vector<double>& costs)
    : graph_(boost::edges_are_unsorted_multi_pass, links.begin(), links.end(), nodes) {
  // Boost sorts the edges by their first node. Edges with the same first node keep their order. `sorted` has the costs
  // in this new order.
  std::vector<std::size_t> next(nodes + 1, 0);
  for (const Link& link : links)
    ++next[link.first + 1];
  for (std::size_t i = 0; i < nodes; ++i)
    next[i + 1] += next[i];
  std::vector<double> sorted(costs.size());
  for (std::size_t k = 0; k < links.size(); ++k)
    sorted[next[links[k].first]++] = costs[k];
  std::size_t k = 0;
  for (const auto& edge : boost::make_iterator_range(boost::edges(graph_)))
    graph_[edge].value = sorted[k++];
}

ShortestPaths CostGraph::from(std::size_t start) const {
  ShortestPaths paths;
  paths.cost.resize(boost::num_vertices(graph_));
  paths.previous.resize(boost::num_vertices(graph_));
  boost::dijkstra_shortest_paths(
      graph_, start,
      boost::weight_map(boost::get(&Cost::value, graph_))
          .distance_map(boost::make_iterator_property_map(paths.cost.begin(), boost::get(boost::vertex_index, graph_)))
          .predecessor_map(
              boost::make_iterator_property_map(paths.previous.begin(), boost::get(boost::vertex_index, graph_)))
          .distance_inf(unreached));
  return paths;
}

} // namespace anatomy
