// Diagnostics of a run: the parts of the model that it leaves out, and warnings.
#pragma once
#include "vci/procedure/stent_history.hpp"
#include "vci/scene/scene.hpp"

#include <optional>

namespace vci {

/// Parts of the model that a scene does not use. @param held, vertices of the wall that stay where they are, of all
std::vector<std::string> left_out(const Scene& scene, std::size_t held, std::size_t vertices);

/// Inflations above a balloon's rated burst pressure.
std::vector<std::string> warnings_of_plan(const Scene& scene);

/// A stent with a ring opened beyond its maximal diameter. Struts run out of length by the ring's perimeter, whatever
/// its shape: its diameter here is that of the circle as long as the ring.
std::optional<std::string> overexpansion(const System& system, const StentHistory& history, const StentSpec& spec,
                                         const std::string& step);

} // namespace vci
