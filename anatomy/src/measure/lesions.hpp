// The narrowings of the branches.
#pragma once
#include "measure/reference.hpp"

namespace anatomy {

struct Lesion {
  std::size_t branch = 0;                   ///< index of the branch
  double s_start = 0, s_mla = 0, s_end = 0; ///< mm along the branch: start, greatest stenosis, end
  double mla = 0, mld = 0;                  ///< area at s_mla (mm2), and the diameter of a circle of that area (mm)
  double reference = 0, proximal_reference = 0, distal_reference = 0; ///< mm, healthy: at s_mla, s_start, s_end
  double diameter_stenosis = 0, area_stenosis = 0;                    ///< per cent of the reference
  double mla_error = 0; ///< possible error by coarse voxels, per cent of mla (coarse_mask.hpp)
};

/// The lesions, most severe first. A lesion is a stretch whose diameter stenosis exceeds `shoulder_stenosis` per cent
/// throughout. It is at least 1 mm long and reaches `least_stenosis` per cent, or is shorter and reaches 50 per cent. A
/// stretch is split if the stenosis between two narrowings is less than that of the milder one by the share
/// `split_recovery`. A lesion is measured at its greatest stenosis. If other sections have nearly the same ratio to the
/// reference, within 3 %, the one of the smallest diameter counts.
std::vector<Lesion> find_lesions(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                                 const std::vector<ReferenceProfile>& profiles);

constexpr double least_stenosis = 8; ///< per cent by diameter: a stretch that does not reach it is no lesion
constexpr double shoulder_stenosis =
    4;                                 ///< per cent by diameter: a lesion begins and ends where the stenosis exceeds it
constexpr double split_recovery = 0.5; ///< share of the milder narrowing's stenosis

} // namespace anatomy
