// Reference profiles that taper more than coronary arteries do.
#pragma once
#include "measure/reference.hpp"

namespace anatomy {

/// `notes` takes a warning of each stretch of 15 mm or more between two forks whose reference tapers twice as much as
/// an LAD does: by 1 % of its first diameter per mm or more, and by 0.037 mm per mm or more. Diffuse disease that
/// narrows a vessel evenly looks the same.
void note_steep_tapers(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                       const std::vector<ReferenceProfile>& profiles, std::vector<Repair>& notes);

} // namespace anatomy
