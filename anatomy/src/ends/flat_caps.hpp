// Flat end caps of a closed surface, by their shape.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// Tags the flat end caps of a closed mesh by shape: planar patches (within 12 degrees and 3 % of their size), round,
/// from whose rim the wall leaves along the normal, and of at least this radius (mm). A patch already tagged is left
/// alone.
void tag_flat_caps(Mesh& mesh, double least_radius = 0);

} // namespace anatomy
