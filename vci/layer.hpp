// One interface for the models of a wall layer: constant-strain triangles or springs.
#pragma once
#include "vci/hencky_law.hpp"
#include "vci/system.hpp"

namespace vci {

struct WallSpec;

/// What a wall layer tells beyond its forces.
class Layer {
public:
  virtual ~Layer() = default;
  /// Largest total (elastic and plastic) principal stretch of each triangle.
  virtual std::vector<double> largest_stretch(const Vectors& x) const = 0;
};

/// Per vertex the largest stretch of the triangles round it, at least 1.
std::vector<double> vertex_stretch(const Layer& layer, const Triangles& triangles, const Vectors& x);

/// Adds a layer to a body by the wall model that the scene asks for; it lives as long as the body.
/// @param reference positions of the unstressed state; @param laws per triangle.
const Layer& add_layer(System& system, int body, const WallSpec& spec, const Triangles& triangles,
                       const Vectors& reference, std::vector<HenckyLaw> laws);

} // namespace vci
