// Diagnostics of a run: the parts of the model that it leaves out, and warnings.
#pragma once
#include "vci/procedure/stent_history.hpp"
#include "vci/scene/scene.hpp"

#include <optional>

namespace vci {

/// Parts of the model that a scene does not use. @param held, vertices: numbers of the wall's fixed and of all vertices
std::vector<std::string> left_out(const Scene& scene, std::size_t held, std::size_t vertices);

/// Inflations above a balloon's rated burst pressure.
std::vector<std::string> warnings_of_plan(const Scene& scene);

/// Warning of a stent with a ring opened beyond its maximal diameter. Struts are limited by the ring's perimeter,
/// whatever its shape. So the ring's diameter here is of the circle with the same perimeter.
std::optional<std::string> overexpansion(const System& system, const StentHistory& history, const StentSpec& spec,
                                         const std::string& step);

} // namespace vci
