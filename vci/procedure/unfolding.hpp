// Contacts and solver settings that a stage with a folded balloon adds.
#pragma once
#include "vci/devices/balloon/balloon.hpp"
#include "vci/scene/scene.hpp"

namespace vci {

/// Lets the layers of a balloon touch one another, if it is folded.
void add_layers(Interactions& interactions, const System& system, const Balloon& balloon, const BalloonSpec& spec,
                const ContactSettings& settings);

/// Solver settings of a stage with a balloon. A folded balloon needs more accurate linear solves. Its stage is not
/// refused while the residual stagnates, because the residual falls only after the folds have opened.
/// @param unfolds whether the balloon starts folded, which needs shorter steps: a layer must not pass its neighbours
IntegratorSettings with_folds(const IntegratorSettings& settings, const BalloonSpec& spec, bool unfolds);

/// Whether a balloon of the scene is folded.
bool any_folded(const Scene& scene);

} // namespace vci
