// What a stage with a folded balloon needs in addition.
#pragma once
#include "vci/devices/balloon/balloon.hpp"
#include "vci/scene/scene.hpp"

namespace vci {

/// Lets the layers of a balloon touch one another, if it is folded.
void add_layers(Interactions& interactions, const System& system, const Balloon& balloon, const BalloonSpec& spec,
                const ContactSettings& settings);

/// Settings of a stage with a balloon. Only a folded one changes them. Its linear solves are more accurate, and the
/// stage is not given up while the residual stays, since that does not fall before the folds are out.
/// @param unfolds the balloon starts folded: shorter steps, which do not carry a layer past its neighbours
IntegratorSettings with_folds(const IntegratorSettings& settings, const BalloonSpec& spec, bool unfolds);

/// True where a balloon of the scene is folded.
bool any_folded(const Scene& scene);

} // namespace vci
