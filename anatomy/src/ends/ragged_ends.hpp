// Open ends whose rim is a sawtooth, as deleting triangles leaves it: flattening would fold the triangles beside it.
#pragma once
#include "ends/open_end.hpp"

namespace anatomy {

/// Cuts a closed mesh across behind each end that is ragged, or whose cap the repair of self-intersections has changed,
/// and caps it: at the first plane where the next one, an edge farther in, finds the same section (area and place
/// within 5 %). Each is warned of in `repairs`, with what it loses. Throws InputError where none of six planes does.
void cut_ragged(Mesh& mesh, const std::vector<OpenEnd>& ends, std::vector<Repair>& repairs);

} // namespace anatomy
