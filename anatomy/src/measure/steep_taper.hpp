// Reference profiles that taper more than coronary arteries do.
#pragma once
#include "measure/reference.hpp"

namespace anatomy {

/// Adds a warning to `notes` for each stretch between two forks whose reference tapers twice as much as an LAD does. A
/// warned stretch is at least 15 mm long. It tapers by 1 % of its first diameter per mm or more, and by 0.037 mm per mm
/// or more. Diffuse disease that narrows a vessel evenly looks the same.
void note_steep_tapers(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                       const std::vector<ReferenceProfile>& profiles, std::vector<Repair>& notes);

} // namespace anatomy
