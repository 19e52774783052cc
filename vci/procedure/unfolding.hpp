// Contacts and solver settings that a stage with a folded balloon adds.
#pragma once
#include "vci/devices/balloon/balloon.hpp"
#include "vci/scene/scene.hpp"

namespace vci {

/// Lets the layers of a balloon touch one another, if it is folded.
void add_layers(Interactions& interactions, const System& system, const Balloon& balloon, const BalloonSpec& spec,
                const ContactSettings& settings);

/// Solver settings of a stage with a balloon. A folded balloon asks for more accurate linear solves. Its stage is not
/// given up while the residual stays, because the residual does not fall before the folds have opened.
/// @param unfolds the balloon starts folded: shorter steps, which do not carry a layer past its neighbours
IntegratorSettings with_folds(const IntegratorSettings& settings, const BalloonSpec& spec, bool unfolds);

/// True where a balloon of the scene is folded.
bool any_folded(const Scene& scene);

} // namespace vci
