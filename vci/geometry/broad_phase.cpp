#include "vci/geometry/broad_phase.hpp"
#include "vci/geometry/closest_point.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fcl/broadphase/detail/hierarchy_tree.h>
#include <fcl/math/bv/AABB.h>

namespace vci {

using Box = fcl::AABB<double>;
using Node = fcl::detail::NodeBase<Box>;

struct BroadPhase::Tree {
  fcl::detail::HierarchyTree<Box> hierarchy;
  std::vector<Node*> leaves;
  std::vector<int> vertices; ///< vertices of the triangles, ascending
  Vectors fitted_positions;  ///< positions of these vertices when the boxes were last fitted, mm
  double largest_move = 0;   ///< largest displacement of a vertex since then, mm
};

namespace {

// mm: displacement after which boxes are fitted again. Fitting more often takes longer than searching in larger boxes.
constexpr double refit_distance = 0.1;

Box box_of(const Triangle& t, const Vectors& x) {
  return Box(x[t[0]], x[t[1]], x[t[2]]);
}

double squared_distance(const Box& box, const Vec3& p) {
  return (box.min_ - p).cwiseMax(p - box.max_).cwiseMax(0.0).squaredNorm();
}

/// A search in progress. Its reach shrinks as nearer triangles are found.
struct Search {
  const Vec3& p;
  const Triangles& triangles;
  const Vectors& x;
  double slack, reach;
  double largest_move; // largest displacement since the boxes were fitted: a triangle may lie this far outside its box
  std::vector<NearTriangle>& hits;

  void visit(const Node* node) {
    if (node->isLeaf()) {
      const int k = static_cast<int>(reinterpret_cast<std::intptr_t>(node->data));
      const Triangle& t = triangles[k];
      const ClosestPoint c = closest_on_triangle(p, x[t[0]], x[t[1]], x[t[2]]);
      if (c.distance_squared <= reach * reach) {
        const double distance = std::sqrt(c.distance_squared);
        hits.push_back({k, distance, c.weights});
        reach = std::min(reach, distance + slack);
      }
      return;
    }
    const Node *near = node->children[0], *far = node->children[1];
    double d_near = squared_distance(near->bv, p), d_far = squared_distance(far->bv, p);
    if (d_far < d_near) {
      std::swap(near, far);
      std::swap(d_near, d_far);
    }
    visit_within_reach(near, d_near);
    visit_within_reach(far, d_far);
  }
  void visit_within_reach(const Node* node, double squared) {
    if (squared <= (reach + largest_move) * (reach + largest_move))
      visit(node);
  }
};

} // namespace

BroadPhase::BroadPhase(const Triangles& triangles, const Vectors& x) : tree_(std::make_unique<Tree>()) {
  for (std::size_t k = 0; k < triangles.size(); ++k)
    tree_->leaves.push_back(
        tree_->hierarchy.insert(box_of(triangles[k], x), reinterpret_cast<void*>(static_cast<std::intptr_t>(k))));
  for (const Triangle& t : triangles)
    tree_->vertices.insert(tree_->vertices.end(), t.begin(), t.end());
  std::sort(tree_->vertices.begin(), tree_->vertices.end());
  tree_->vertices.erase(std::unique(tree_->vertices.begin(), tree_->vertices.end()), tree_->vertices.end());
  for (int v : tree_->vertices)
    tree_->fitted_positions.push_back(x[v]);
}

BroadPhase::~BroadPhase() = default;
BroadPhase::BroadPhase(BroadPhase&&) noexcept = default;
BroadPhase& BroadPhase::operator=(BroadPhase&&) noexcept = default;

void BroadPhase::update(const Triangles& triangles, const Vectors& x) {
  double squared = 0;
  for (std::size_t k = 0; k < tree_->vertices.size(); ++k)
    squared = std::max(squared, (x[tree_->vertices[k]] - tree_->fitted_positions[k]).squaredNorm());
  tree_->largest_move = std::sqrt(squared);
  if (tree_->largest_move <= refit_distance)
    return;
  tree_->largest_move = 0;
  for (std::size_t k = 0; k < tree_->vertices.size(); ++k)
    tree_->fitted_positions[k] = x[tree_->vertices[k]];
  for (std::size_t k = 0; k < triangles.size(); ++k) {
    const Vec3 &a = x[triangles[k][0]], &b = x[triangles[k][1]], &c = x[triangles[k][2]];
    Box& box = tree_->leaves[k]->bv;
    box.min_ = a.cwiseMin(b).cwiseMin(c);
    box.max_ = a.cwiseMax(b).cwiseMax(c);
  }
  tree_->hierarchy.refit();
}

void BroadPhase::find_near(const Vec3& p, const Triangles& triangles, const Vectors& x, double reach, double slack,
                           int guess, std::vector<NearTriangle>& hits) const {
  hits.clear();
  if (tree_->leaves.empty())
    return;
  if (guess >= 0) { // the nearest triangle is at most as far away as this one
    const Triangle& t = triangles[guess];
    reach = std::min(reach, std::sqrt(closest_on_triangle(p, x[t[0]], x[t[1]], x[t[2]]).distance_squared) + slack);
  }
  Search search{p, triangles, x, slack, reach, tree_->largest_move, hits};
  search.visit(tree_->hierarchy.getRoot());
  std::erase_if(hits, [&](const NearTriangle& f) { return f.distance > search.reach; });
  std::sort(hits.begin(), hits.end(), [](const auto& a, const auto& b) { return a.triangle < b.triangle; });
}

} // namespace vci
