#include "vci/results/coarse_lumen.hpp"
#include "common/error.hpp"

namespace vci {

namespace {

Scene with_coarse_lumen(Scene scene) {
  scene.lumen = scene.coarse_lumen;
  return scene;
}

} // namespace

CoarseLumen::CoarseLumen(const Scene& scene, const Lumen& fine)
    : scene_(with_coarse_lumen(scene)), lumen_(read_lumen(scene_.lumen)),
      carried_(lumen_.triangles, lumen_.points, fine.points) {
  for (std::size_t v = 0; v < fine.points.size(); ++v)
    if (const double distance = carried_.distances()[v]; distance > fine.radius[v])
      throw common::InputError(
          "coarse_lumen is not this lumen on longer edges", scene_.lumen.string(),
          common::text(distance, " mm from a point of the lumen"),
          "make it of the same lumen: lumen process LUMEN --edge 0.8 --like anatomy.json --out DIR");
}

DeploymentResult CoarseLumen::carry_to_fine(DeploymentResult result) const {
  result.points = carried_.displaced_points(result.points);
  result.wall_stretch = carried_.interpolate(result.wall_stretch);
  result.malapposition = carried_.interpolate(result.malapposition);
  return result;
}

std::optional<CoarseLumen> load_coarse_lumen(const Scene& scene, const Lumen& fine) {
  if (scene.coarse_lumen.empty())
    return std::nullopt;
  return CoarseLumen(scene, fine);
}

} // namespace vci
