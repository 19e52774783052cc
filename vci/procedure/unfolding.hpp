// Contacts and solver settings that a stage with a folded balloon adds.
#pragma once
#include "vci/devices/balloon/balloon.hpp"
#include "vci/scene/scene.hpp"

namespace vci {

/// Adds contact between the layers of a folded balloon. Does nothing for a balloon that is not folded.
void add_layer_contacts(Interactions& interactions, const System& system, const Balloon& balloon,
                        const BalloonSpec& spec, const ContactSettings& settings);

/// Solver settings of a stage with a balloon; unchanged if the balloon is not folded. A folded balloon needs shorter
/// steps and more accurate linear solves. Its stage is not refused while the residual stagnates, because the residual
/// falls only after the folds have opened.
/// @param unfolds whether the folds open in this stage; steps are then even shorter, so that layers do not cross
IntegratorSettings folded_balloon_settings(const IntegratorSettings& settings, const BalloonSpec& spec, bool unfolds);

/// Whether a balloon of the scene is folded.
bool has_folded_balloon(const Scene& scene);

} // namespace vci
