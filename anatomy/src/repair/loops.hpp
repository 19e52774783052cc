// Boundary loops of an open surface: which are ends of the vessel and which are holes in its wall.
#pragma once
#include "core/types.hpp"

namespace anatomy {

struct Loop {
  Halfedge halfedge; ///< a border halfedge of the loop
  std::size_t halfedges = 0;
  Vec3 centre = Vec3::Zero(); ///< mean of the corners weighted by edge length
  Vec3 normal = Vec3::Zero(); ///< unit, of the least-squares plane (sense by the loop's direction)
  double area = 0;            ///< projected on that plane, mm2
};

constexpr double smallest_end = 0.15; ///< mm, radius; openings where a cut grazes a rough wall are smaller

/// The loops in a stable order (by their first halfedge).
std::vector<Loop> boundary_loops(const Mesh& mesh);

/// Whether the loop is the opening of a tube: the wall leaves the rim along the rim's normal (mean |n_face . n_loop| <
/// 0.6).
bool is_open_end(const Mesh& mesh, const Loop& loop);

} // namespace anatomy
