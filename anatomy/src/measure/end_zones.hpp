// The lumen within 1.5 radii of the ends, where no section is measured.
#pragma once
#include "measure/lesions.hpp"

namespace anatomy {

/// The reference comes from sections at least 1.5 radii from the ends. Where a lesion begins within 2.5 radii of an
/// end, the healthy vessel may lie at that end alone. `notes` takes a warning if an inscribed ball between the two is
/// wider than the reference by 10 %, more than an ostium's mouth widens a vessel. It states the stenosis by that width
/// as well.
void note_wide_ends(const std::vector<Branch>& branches, const std::vector<ReferenceProfile>& profiles,
                    const std::vector<Lesion>& lesions, std::vector<Repair>& notes);

/// Warns of a lumen that goes on narrowing there: by 20 % of the reference or more, and by 5 points more than in the
/// first section that is measured. The diameter is that section's, times the ratio of the inscribed balls, or that of
/// the section in the end zone if it is larger.
void note_narrow_ends(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                      const std::vector<ReferenceProfile>& profiles, std::vector<Repair>& notes);

} // namespace anatomy
