// Open ends with a sawtooth rim, as deleted triangles leave it. Flattening would fold the triangles beside it.
#pragma once
#include "ends/open_end.hpp"

namespace anatomy {

/// Cuts a closed mesh across behind each ragged end, and caps it. The same is done behind a cap that the repair of
/// self-intersections has changed. Up to eight planes are tried, an edge apart. The cut is the first whose section is
/// like the next two: areas within 5 %, and equal steps between the centres, within 5 % of the radius. So a cut behind
/// an oblique rim is oblique. `repairs` takes a warning of each cut with the length and the wall lost. Throws
/// InputError if no plane is found.
void cut_ragged(Mesh& mesh, const std::vector<OpenEnd>& ends, std::vector<Repair>& repairs);

} // namespace anatomy
