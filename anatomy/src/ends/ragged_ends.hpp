// Open ends whose rim is a sawtooth, as deleting triangles leaves it: flattening would fold the triangles beside it.
#pragma once
#include "ends/open_end.hpp"

namespace anatomy {

/// Cuts a closed mesh across behind each ragged end, and caps it. The same is done behind a cap that the repair of
/// self-intersections has changed. The cut is the first plane of eight, an edge apart, from which the next two planes
/// find the same section: areas within 5 %, and centres that go on by the same step within 5 % of the radius. So an
/// oblique rim is cut obliquely. `repairs` takes a warning of each cut with what it loses. Throws InputError
/// where no plane is found.
void cut_ragged(Mesh& mesh, const std::vector<OpenEnd>& ends, std::vector<Repair>& repairs);

} // namespace anatomy
