// What stages with a folded balloon need beside others.
#pragma once
#include "vci/devices/balloon/balloon.hpp"
#include "vci/scene/scene.hpp"

namespace vci {

/// Lets the layers of a balloon touch one another, if it is folded.
void add_layers(Interactions& interactions, const System& system, const Balloon& balloon, const BalloonSpec& spec,
                const ContactSettings& settings);

/// Settings of a stage with a balloon, as they are unless it is folded: folds give a sharper linear solve and no end
/// for want of a better residual, which does not fall before they are out.
/// @param unfolds the balloon starts folded: steps that do not carry a layer past the next ones
IntegratorSettings with_folds(const IntegratorSettings& settings, const BalloonSpec& spec, bool unfolds);

/// True where a balloon of the scene is folded.
bool any_folded(const Scene& scene);

} // namespace vci
