// Boundary loops of an open surface: which are ends of the vessel and which are holes in its wall.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// A closed loop of border edges.
struct Loop {
  Halfedge halfedge;          ///< a border halfedge of the loop
  std::size_t halfedges = 0;  ///< number of its halfedges
  Vec3 centre = Vec3::Zero(); ///< mean of the edges' midpoints weighted by edge length, mm
  Vec3 normal = Vec3::Zero(); ///< unit normal of the plane of largest projected area; oriented by the loop's direction
  double area = 0;            ///< area within the loop, projected on that plane, mm2
};

/// Least radius (mm) of an end. Where a cut grazes a rough wall it leaves smaller loops, which are holes.
constexpr double smallest_end = 0.15;

/// The boundary loops of an open surface; the order is the same in every run.
std::vector<Loop> boundary_loops(const Mesh& mesh);

/// Whether the loop is the open end of a tube rather than a hole in its wall. Round a hole the faces lie in the loop's
/// plane. At an end they stand across it, so the mean of |n_face . n_loop| over the faces at the loop is below 0.6.
bool is_open_end(const Mesh& mesh, const Loop& loop);

} // namespace anatomy
