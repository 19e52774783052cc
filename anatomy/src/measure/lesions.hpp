// The narrowings of the branches.
#pragma once
#include "measure/reference.hpp"

namespace anatomy {

struct Lesion {
  std::size_t branch = 0;
  double s_start = 0, s_mla = 0, s_end = 0;                           ///< mm
  double mla = 0, mld = 0;                                            ///< mm2, mm
  double reference = 0, proximal_reference = 0, distal_reference = 0; ///< diameters, mm
  double diameter_stenosis = 0, area_stenosis = 0;                    ///< per cent
  double mla_error = 0; ///< possible error by coarse voxels, per cent of mla (coarse_mask.hpp)
};

/// Stretches at least 1 mm long whose diameter stenosis exceeds `shoulder` per cent throughout and reaches
/// `least_stenosis` per cent, and shorter ones that reach 50 per cent; most severe first. A stretch is split if the
/// lumen between two narrowings recovers `recovered` of the lesser one's stenosis. It is measured where the stenosis is
/// greatest; of places whose diameters agree within 3 % of the reference's course, at the smallest.
std::vector<Lesion> find_lesions(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                                 const std::vector<ReferenceProfile>& profiles);

constexpr double least_stenosis = 8; ///< per cent by diameter
constexpr double shoulder = 4;       ///< per cent by diameter
constexpr double recovered = 0.5;    ///< of the lesser narrowing's stenosis

} // namespace anatomy
