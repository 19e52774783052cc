#include "vci/procedure/unfolding.hpp"

#include <algorithm>

namespace vci {

namespace {

// The layers of rings narrower than this share of the body's diameter have no contact, since folds in the balloon's
// necks are too fine for contact.
constexpr double least_layer_profile = 0.6;
// While folds open, a step is to move vertices by at most this multiple of the film's thickness. Linear solves with a
// folded balloon have this relative residual.
constexpr double step_over_thickness = 2, folds_pcg_tolerance = 0.05;
constexpr double folds_maximal_step = 5;    // ms: a kink left in the cones oscillates under longer steps
constexpr double folds_initial_step = 0.03; // ms: a longer first step moves layers through one another

} // namespace

void add_layer_contacts(Interactions& interactions, const System& system, const Balloon& balloon,
                        const BalloonSpec& spec, const ContactSettings& settings) {
  if (!spec.folding)
    return;
  std::vector<double> thickness;
  for (double profile : balloon.grid.profile)
    thickness.insert(thickness.end(), balloon.grid.ring_size,
                     profile < least_layer_profile ? 0.0 : spec.folding->membrane_thickness * profile);
  interactions.self_contacts.emplace_back(system, balloon.body, settings.stiffness, std::move(thickness));
}

IntegratorSettings folded_balloon_settings(const IntegratorSettings& settings, const BalloonSpec& spec, bool unfolds) {
  IntegratorSettings adapted = settings;
  if (!spec.folding)
    return adapted;
  adapted.stalled_steps = settings.maximal_steps;
  adapted.maximal_step = std::min(settings.maximal_step, folds_maximal_step);
  adapted.pcg.tolerance = std::min(settings.pcg.tolerance, folds_pcg_tolerance);
  if (unfolds) {
    adapted.initial_step = std::min(settings.initial_step, folds_initial_step);
    adapted.displacement_per_step =
        std::min(settings.displacement_per_step, step_over_thickness * spec.folding->membrane_thickness);
  }
  return adapted;
}

bool has_folded_balloon(const Scene& scene) {
  return std::any_of(scene.balloons.begin(), scene.balloons.end(),
                     [](const auto& entry) { return entry.second.folding.has_value(); });
}

} // namespace vci
