// The narrowings of the branches.
#pragma once
#include "measure/reference.hpp"

namespace anatomy {

struct Lesion {
  std::size_t branch = 0;                   ///< index of the branch
  double s_start = 0, s_mla = 0, s_end = 0; ///< mm along the branch: start, greatest stenosis, end
  double mla = 0, mld = 0;                  ///< area at s_mla (mm2), and the diameter of a circle of that area (mm)
  double reference = 0, proximal_reference = 0, distal_reference = 0; ///< mm, healthy diameter at s_mla, s_start, s_end
  double diameter_stenosis = 0, area_stenosis = 0;                    ///< per cent of the reference
  double mla_error = 0; ///< possible error by coarse voxels, per cent of mla (coarse_mask.hpp)
};

/// The lesions, most severe first. A lesion is a stretch whose diameter stenosis exceeds `shoulder_stenosis` per cent
/// throughout. It is at least 1 mm long and reaches `least_stenosis` per cent, or is shorter and reaches 50 per cent. A
/// stretch is split between two narrowings if the stenosis there is less than the milder narrowing's by the share
/// `split_recovery`. A lesion is measured at its greatest stenosis. If other sections have nearly the same ratio to the
/// reference, within 3 %, the one of the smallest diameter counts.
std::vector<Lesion> find_lesions(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                                 const std::vector<ReferenceProfile>& profiles);

constexpr double least_stenosis = 8; ///< per cent of the diameter; a stretch that nowhere reaches this is no lesion
/// Per cent of the diameter; a lesion begins and ends where the stenosis exceeds this.
constexpr double shoulder_stenosis = 4;
constexpr double split_recovery = 0.5; ///< share of the milder narrowing's stenosis that vanishes between two lesions

} // namespace anatomy
