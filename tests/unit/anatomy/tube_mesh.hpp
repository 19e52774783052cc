// Swept tubes as repaired meshes with tagged caps.
#pragma once
#include "ends/ends.hpp"
#include "ends/find_ends.hpp"
#include "repair/repair.hpp"
#include "tube.hpp"

namespace anatomy::shapes {

/// Tags the ends of a closed mesh as the program finds them; returns what it looked at.
inline std::vector<EndCandidate> tag_ends(Mesh& mesh, const NamedEnds& named = {}) {
  std::vector<Repair> repairs;
  return find_ends(mesh, named, 0, repairs);
}

inline Mesh mesh_of(const Tube& tube) {
  std::vector<Repair> repairs;
  Mesh mesh = repaired(soup_of(tube), repairs);
  tag_ends(mesh);
  measure_ends(mesh);
  return mesh;
}

} // namespace anatomy::shapes
