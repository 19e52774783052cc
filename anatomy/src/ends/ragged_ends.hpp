// Cuts off open ends with a sawtooth rim, which deleted triangles leave. Flattening such a rim would fold the triangles
// beside it.
#pragma once
#include "ends/open_end.hpp"

namespace anatomy {

/// Cuts a closed mesh across behind each ragged end, and caps it. The same is done behind a cap that the repair of
/// self-intersections has changed. Up to eight planes are tried, an edge length apart. The cut is the first plane whose
/// section is like the next two. Like sections have areas within 5 % of each other, and the steps between their centres
/// are equal within 5 % of the radius. The centres may move sideways, so a cut behind an oblique rim is oblique.
/// `repairs` takes a warning of each cut, with the length of vessel and the area of wall that are lost. Throws
/// InputError if no plane is found.
void cut_ragged(Mesh& mesh, const std::vector<OpenEnd>& ends, std::vector<Repair>& repairs);

} // namespace anatomy
