#include "vci/procedure/region.hpp"

#include <algorithm>

namespace vci {

std::vector<char> region_of_interest(const Lumen& lumen, const Scene& scene, const std::map<std::string, Path>& paths) {
  std::vector<char> free(lumen.points.size(), 0);
  for (const Step& step : scene.procedure)
    for (const Placement& p : step.devices) {
      const double half =
          0.5 * scene.opened_length(p.device) + scene.balloon(p.device).shoulder + scene.numerics.region_margin;
      const Path& path = paths.at(p.branch);
      for (double s = p.centre_s - half; s <= p.centre_s + half; s += 0.5) {
        const Vec3 centre = path.at(s);
        for (std::size_t v = 0; v < lumen.points.size(); ++v) {
          const double reach = lumen.radius[v] + 1.0; // lateral: the branch itself and the mouths of its sides
          if ((lumen.points[v] - centre).squaredNorm() < reach * reach)
            free[v] = 1;
        }
      }
    }
  return free;
}

} // namespace vci
