// A tube whose tree and sections are measured as by the program.
#pragma once
#include "ends/ends.hpp"
#include "measure/sections.hpp"
#include "repair/repair.hpp"
#include "trees/naming.hpp"
#include "tube_mesh.hpp"

namespace anatomy::shapes {

struct Measured {
  Mesh mesh;
  std::vector<End> ends;
  std::vector<Branch> branches;
  std::vector<Section> sections;
};

inline Measured measured(const Tube& tube) {
  std::vector<Repair> repairs;
  Measured out;
  out.mesh = repaired(soup_of(tube), repairs);
  tag_ends(out.mesh);
  out.ends = measure_ends(out.mesh);
  const std::size_t inlet = inlet_of(out.ends, tube.axis(0));
  const WallTree wall(out.mesh);
  out.branches = build_tree(voronoi_paths(out.mesh, out.ends, inlet), out.ends, inlet, wall, 0.25, {});
  out.sections = cut_sections(out.mesh, out.branches, out.ends);
  return out;
}

} // namespace anatomy::shapes
