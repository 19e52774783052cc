// Swept tubes as repaired meshes with tagged caps.
#pragma once
#include "ends/ends.hpp"
#include "ends/flat_caps.hpp"
#include "repair/repair.hpp"
#include "tube.hpp"

namespace anatomy::shapes {

inline Mesh mesh_of(const Tube& tube) {
  std::vector<Repair> repairs;
  Mesh mesh = repaired(soup_of(tube), repairs);
  tag_flat_caps(mesh);
  measured_ends(mesh);
  return mesh;
}

} // namespace anatomy::shapes
