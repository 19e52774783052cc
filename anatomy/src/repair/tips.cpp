#include "repair/tips.hpp"
#include "core/shortest_paths.hpp"
#include <algorithm>
#include <numeric>
#include <set>

namespace anatomy {
namespace {

// The graph of the mesh's edges in both directions, with their lengths (mm) as costs.
CostGraph edge_graph(const Mesh& mesh) {
  std::vector<CostGraph::Link> links;
  std::vector<double> lengths;
  for (Halfedge h : mesh.halfedges()) {
    links.emplace_back(mesh.source(h), mesh.target(h));
    lengths.push_back((vec(mesh.point(mesh.target(h))) - vec(mesh.point(mesh.source(h)))).norm());
  }
  return {mesh.number_of_vertices(), links, lengths};
}

std::size_t farthest(const std::vector<double>& d) {
  return static_cast<std::size_t>(std::max_element(d.begin(), d.end()) - d.begin());
}

// The vertices sorted by their distance from an extremity of the surface (`root`), the farthest first. The searches for
// tips and handles visit them in this order. `height` is the distance in mm along the edges. The extremity is the
// vertex farthest from vertex 0. With `from_far_end` it is the vertex farthest from that one.
struct Sweep {
  std::size_t root = 0;
  std::vector<double> height;
  std::vector<std::size_t> order;

  explicit Sweep(const Mesh& mesh, bool from_far_end = false) {
    const CostGraph graph = edge_graph(mesh);
    root = farthest(graph.from(0).cost);
    if (from_far_end)
      root = farthest(graph.from(root).cost);
    height = graph.from(root).cost;
    order.resize(height.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [this](std::size_t a, std::size_t b) { return higher(a, b); });
  }
  bool higher(std::size_t a, std::size_t b) const { return height[a] != height[b] ? height[a] > height[b] : a < b; }
};

// Sets of connected vertices by union-find. One vertex represents each set; the links `above` lead to it.
struct UnionFind {
  std::vector<std::size_t> above;
  explicit UnionFind(std::size_t n) : above(n) { std::iota(above.begin(), above.end(), 0); }
  std::size_t highest(std::size_t v) {
    while (above[v] != v)
      v = above[v] = above[above[v]];
    return v;
  }
};

} // namespace

std::vector<Tip> tips_of(const Mesh& mesh, double least_prominence, bool from_far_end) {
  const Sweep sweep(mesh, from_far_end);
  const std::vector<double>& height = sweep.height;
  UnionFind higher_parts(height.size());
  std::vector<Tip> tips;
  const auto keep = [&](std::size_t v, double prominence, bool is_extremity = false) {
    if (prominence >= least_prominence)
      tips.push_back({Vertex(static_cast<Mesh::size_type>(v)), prominence, is_extremity});
  };
  // Vertices are added from the highest down. Where two parts meet, the part with the lower tip ends. The prominence of
  // this tip is its height over the meeting place.
  for (std::size_t v : sweep.order)
    for (Vertex w : mesh.vertices_around_target(mesh.halfedge(Vertex(static_cast<Mesh::size_type>(v))))) {
      if (!sweep.higher(w, v))
        continue;
      std::size_t a = higher_parts.highest(v), b = higher_parts.highest(w);
      if (a == b)
        continue;
      if (sweep.higher(b, a))
        std::swap(a, b);
      keep(b, height[b] - height[v]);
      higher_parts.above[b] = a;
    }
  keep(sweep.order.front(), height[sweep.order.front()], true);
  keep(sweep.root, height[sweep.order.front()], true);
  std::stable_sort(tips.begin(), tips.end(), [](const Tip& a, const Tip& b) { return a.prominence > b.prominence; });
  return tips;
}

std::vector<Vertex> places_on_handles(const Mesh& mesh) {
  const long euler = static_cast<long>(mesh.number_of_vertices()) - static_cast<long>(mesh.number_of_edges()) +
                     static_cast<long>(mesh.number_of_faces());
  if (euler == 2)
    return {};
  const Sweep sweep(mesh);
  UnionFind higher_parts(sweep.height.size());
  std::vector<Vertex> places;
  for (std::size_t v : sweep.order) {
    // Shortest distances have no other minimum than the root. So a loop of higher vertices that closes at v encloses no
    // lower part of the surface: it goes round a handle.
    const Vertex here(static_cast<Mesh::size_type>(v));
    std::set<std::size_t> tops;
    std::size_t runs = 0; // number of groups of successive higher neighbours round v
    for (Halfedge h : mesh.halfedges_around_target(mesh.halfedge(here))) {
      const Vertex w = mesh.source(h), after = mesh.target(mesh.next(h));
      if (!sweep.higher(w, v))
        continue;
      runs += !sweep.higher(after, v);
      tops.insert(higher_parts.highest(w));
    }
    if (runs > tops.size())
      places.push_back(here);
    for (std::size_t top : tops)
      higher_parts.above[higher_parts.highest(top)] = v;
    higher_parts.above[v] = v;
  }
  if (places.empty())
    places.push_back(Vertex(static_cast<Mesh::size_type>(sweep.order.front())));
  return places;
}

} // namespace anatomy
