#include "vci/layer.hpp"
#include "vci/mass_spring.hpp"
#include "vci/membrane.hpp"
#include "vci/scene.hpp"

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

const Layer& add_layer(System& system, int body, const WallSpec& spec, const Triangles& triangles,
                       const Vectors& reference, std::vector<HenckyLaw> laws) {
  if (spec.model == "mass-spring")
    return system.add_force(body, std::make_unique<MassSpring>(triangles, reference, laws, spec.spring_mapping));
  return system.add_force(body, std::make_unique<Membrane>(triangles, reference, std::move(laws)));
}

} // namespace vci
