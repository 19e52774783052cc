// Stretches of the lumen that another vessel may be fused to.
#pragma once
#include "measure/reference.hpp"

namespace anatomy {

/// Warns of each stretch of 3 mm and more whose sections are 15 % wider than the reference and more than 1.8 times as
/// long as wide. The outline may then hold a second vessel, such as a vein that touches the artery. A narrowing in such
/// a stretch is not found.
void note_fused_vessels(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                        const std::vector<ReferenceProfile>& profiles, std::vector<Repair>& notes);

} // namespace anatomy
