#include "vci/procedure/diagnostics.hpp"
#include "vci/procedure/unfolding.hpp"
#include "vci/solver/convergence_error.hpp"

#include <algorithm>
#include <sstream>

namespace vci {

std::vector<std::string> switched_off_parts(const Scene& scene, std::size_t held, std::size_t vertices,
                                            bool branches_unknown) {
  std::ostringstream region;
  region << "wall further than " << scene.numerics.region_margin << " mm from every device: " << held << " of "
         << vertices << " vertices stay where they are";
  const bool whole = scene.numerics.integrator.textbook, folded = has_folded_balloon(scene);
  std::vector<std::string> parts{
      whole ? "nothing of the wall: textbook integration takes the whole vessel" : region.str(),
      folded ? "folding of balloons whose entries do not ask for it"
             : "folding: balloons start as small tubes that unfold softly",
      folded ? "self-contact of all but folded balloons" : "self-contact of the wall and of the devices",
      "mean blood pressure during occlusion: kept as prestress"};
  if (branches_unknown)
    parts.push_back("tissue between branches: the lumen has no branch_id, so their walls may cross");
  return parts;
}

std::vector<std::string> warnings_of_plan(const Scene& scene) {
  std::vector<std::string> warnings;
  for (const Step& step : scene.procedure)
    for (const Placement& p : step.devices) {
      const BalloonSpec& balloon = scene.balloon(p.device);
      if (p.pressure_bar <= balloon.rated_burst_pressure_bar)
        continue;
      std::ostringstream text;
      text << step.name << ": " << p.device << " is inflated to " << p.pressure_bar
           << " bar, above its balloon's rated burst pressure of " << balloon.rated_burst_pressure_bar << " bar";
      warnings.push_back(text.str());
    }
  return warnings;
}

std::optional<std::string> overexpansion_warning(const System& system, const StentHistory& h, const StentSpec& spec,
                                                 const std::string& step) {
  const std::vector<double> perimeters = perimeter_diameters(system, h.stent.body, h.stent.grid);
  const auto beyond =
      std::count_if(perimeters.begin(), perimeters.end(), [&](double d) { return d > spec.maximal_diameter; });
  if (beyond == 0)
    return std::nullopt;
  std::ostringstream text;
  text << step << ": " << h.device << " is opened to " << *std::max_element(perimeters.begin(), perimeters.end())
       << " mm by its perimeter, beyond its maximal diameter of " << spec.maximal_diameter << " mm (" << beyond
       << " of " << perimeters.size() << " rings)";
  return text.str();
}

std::optional<std::string> penetration_warning(const RelaxResult& balance, const System& system, double limit,
                                               const std::string& where) {
  if (balance.maximal_penetration <= limit)
    return std::nullopt;
  std::ostringstream text;
  text << where << ": a vertex lies " << balance.maximal_penetration << " mm deep in another surface"
       << describe_deepest(balance, system) << ", more than " << limit << " mm";
  return text.str();
}

} // namespace vci
