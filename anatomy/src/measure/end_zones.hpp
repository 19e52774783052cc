// The lumen within 1.5 radii of the ends, where no section is measured.
#pragma once
#include "measure/lesions.hpp"

namespace anatomy {

/// Warns if a lesion lies within 2.5 radii of an end and the vessel between the two is wider than the reference. The
/// reference comes from sections at least 1.5 radii from the ends, so it misses a healthy vessel at the end alone.
/// Wider means that an inscribed sphere exceeds the reference by 10 %, more than an ostium's mouth widens a vessel. The
/// warning also states the stenosis by that width.
void note_wide_ends(const std::vector<Branch>& branches, const std::vector<ReferenceProfile>& profiles,
                    const std::vector<Lesion>& lesions, std::vector<Repair>& notes);

/// Warns of a lumen that narrows further within 1.5 radii of an end. Its diameter stenosis there is at least 20 %, and
/// at least 5 percentage points more than in the next measured section. The diameter there is the larger of two values.
/// One is the diameter of the next measured section, times the ratio of the inscribed radii. The other is the diameter
/// of the nearest section.
void note_narrow_ends(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                      const std::vector<ReferenceProfile>& profiles, std::vector<Repair>& notes);

} // namespace anatomy
