#include "vci/mechanics/layer.hpp"

#include <algorithm>

namespace vci {

std::vector<double> vertex_stretch(const Layer& layer, const Triangles& triangles, const Vectors& x) {
  const std::vector<double> stretch = layer.largest_stretch(x);
  std::vector<double> largest(x.size(), 1.0);
  for (std::size_t k = 0; k < triangles.size(); ++k)
    for (int v : triangles[k])
      largest[v] = std::max(largest[v], stretch[k]);
  return largest;
}

} // namespace vci
