#include "vci/broad_phase.hpp"

#include <algorithm>
#include <cstdint>
#include <fcl/broadphase/detail/hierarchy_tree.h>
#include <fcl/math/bv/AABB.h>

namespace vci {

using Box = fcl::AABB<double>;
using Node = fcl::detail::NodeBase<Box>;

struct BroadPhase::Tree {
  fcl::detail::HierarchyTree<Box> hierarchy;
  std::vector<Node*> leaves;
};

namespace {

Box box_of(const Triangle& t, const Vectors& x) {
  return Box(x[t[0]], x[t[1]], x[t[2]]);
}

void collect(const Node* node, const Box& query, std::vector<int>& found) {
  if (!node->bv.overlap(query))
    return;
  if (node->isLeaf()) {
    found.push_back(static_cast<int>(reinterpret_cast<std::intptr_t>(node->data)));
    return;
  }
  collect(node->children[0], query, found);
  collect(node->children[1], query, found);
}

} // namespace

BroadPhase::BroadPhase(const Triangles& triangles, const Vectors& x) : tree_(std::make_unique<Tree>()) {
  for (std::size_t k = 0; k < triangles.size(); ++k)
    tree_->leaves.push_back(
        tree_->hierarchy.insert(box_of(triangles[k], x), reinterpret_cast<void*>(static_cast<std::intptr_t>(k))));
}

BroadPhase::~BroadPhase() = default;
BroadPhase::BroadPhase(BroadPhase&&) noexcept = default;
BroadPhase& BroadPhase::operator=(BroadPhase&&) noexcept = default;

void BroadPhase::update(const Triangles& triangles, const Vectors& x) {
  for (std::size_t k = 0; k < triangles.size(); ++k)
    tree_->leaves[k]->bv = box_of(triangles[k], x);
  tree_->hierarchy.refit();
}

void BroadPhase::near(const Vec3& p, double reach, std::vector<int>& found) const {
  found.clear();
  if (tree_->leaves.empty())
    return;
  const Vec3 r = Vec3::Constant(reach);
  collect(tree_->hierarchy.getRoot(), Box(p - r, p + r), found);
  std::sort(found.begin(), found.end());
}

} // namespace vci
