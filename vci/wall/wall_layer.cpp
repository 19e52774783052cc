#include "vci/wall/wall_layer.hpp"
#include "vci/mechanics/membrane.hpp"
#include "vci/wall/mass_spring.hpp"

namespace vci {

const Layer& add_layer(System& system, int body, const WallSpec& spec, const Triangles& triangles,
                       const Vectors& reference, std::vector<HenckyLaw> laws) {
  if (spec.model == WallModel::mass_spring)
    return system.add_force(body, std::make_unique<MassSpring>(triangles, reference, laws, spec.spring_mapping));
  return system.add_force(body, std::make_unique<Membrane>(triangles, reference, std::move(laws)));
}

} // namespace vci
