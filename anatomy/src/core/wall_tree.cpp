#include "core/wall_tree.hpp"

namespace anatomy {

WallTree::WallTree(const Mesh& mesh) {
  const RegionMap region = region_map(mesh);
  std::vector<Face> wall;
  for (Face f : mesh.faces())
    if (region[f] == 0)
      wall.push_back(f);
  tree_.insert(wall.begin(), wall.end(), mesh);
  tree_.build();
  tree_.accelerate_distance_queries();
}

double WallTree::distance(const Vec3& p) const {
  return std::sqrt(tree_.squared_distance(point(p)));
}

} // namespace anatomy
