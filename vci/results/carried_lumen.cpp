#include "vci/results/carried_lumen.hpp"
#include "common/error.hpp"

namespace vci {

CarriedLumen::CarriedLumen(const Lumen& coarse, const Lumen& fine, const std::string& name)
    : carried_(coarse.triangles, coarse.points, fine.points) {
  for (std::size_t v = 0; v < fine.points.size(); ++v)
    if (const double distance = carried_.distances()[v]; distance > fine.radius[v])
      throw common::InputError(
          "coarse_lumen is not this lumen on longer edges", name,
          common::text(distance, " mm from a point of the lumen"),
          "make it of the same lumen: lumen process LUMEN --edge 0.8 --like anatomy.json --out DIR");
}

DeploymentResult CarriedLumen::carried(DeploymentResult result) const {
  result.points = points(result.points);
  result.wall_stretch = carried_.interpolate(result.wall_stretch);
  result.malapposition = carried_.interpolate(result.malapposition);
  return result;
}

} // namespace vci
