// Diagnostics of a run: the parts of the model that it leaves out, and warnings.
#pragma once
#include "vci/procedure/stent_history.hpp"
#include "vci/scene/scene.hpp"

#include <optional>

namespace vci {

/// Texts that name the parts of the model that a run leaves out.
/// @param held number of the lumen's vertices that are held in place
/// @param vertices number of all the lumen's vertices
/// @param branches_unknown whether the vessel has branches, but its triangles do not name theirs
std::vector<std::string> switched_off_parts(const Scene& scene, std::size_t held, std::size_t vertices,
                                            bool branches_unknown);

/// A warning for each inflation above the balloon's rated burst pressure.
std::vector<std::string> warnings_of_plan(const Scene& scene);

/// The warning that rings of a stent are opened beyond the maximal diameter; nothing if no ring is. The struts limit a
/// ring's perimeter, whatever the ring's shape. So the diameter of a circle with this perimeter is compared.
/// @param step name of the step, for the message
std::optional<std::string> overexpansion_warning(const System& system, const StentHistory& history,
                                                 const StentSpec& spec, const std::string& step);

/// The warning that in balance a vertex is deeper in another surface than the solver's `maximal_penetration`; nothing
/// if none is. The deep response has then reached its limit, or the contact has none (folds of one balloon).
/// @param where step and stage, for the message
std::optional<std::string> penetration_warning(const RelaxResult& balance, const System& system, double limit,
                                               const std::string& where);

} // namespace vci
