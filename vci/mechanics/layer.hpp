// The interface of a layer of the wall, which constant-strain triangles and springs share.
#pragma once
#include "vci/linalg/types.hpp"

namespace vci {

/// What a layer of the wall reports besides its forces.
class Layer {
public:
  virtual ~Layer() = default;
  /// Largest total (elastic and plastic) principal stretch of each triangle.
  virtual std::vector<double> largest_stretch(const Vectors& x) const = 0;
};

/// For each vertex of the system, the largest stretch of the triangles round it; at least 1.
std::vector<double> vertex_stretch(const Layer& layer, const Triangles& triangles, const Vectors& x);

} // namespace vci
