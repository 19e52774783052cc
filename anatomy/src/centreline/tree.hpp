// The vascular tree: paths split into named branches with smooth axes.
#pragma once
#include "centreline/axis.hpp"
#include "centreline/voronoi.hpp"
#include "core/wall_tree.hpp"

namespace anatomy {

struct Branch {
  std::string name;    ///< main, side1, ...
  int id = 0;          ///< 0, 1, ...
  int parent = -1;     ///< index in the list of branches; -1 for main
  std::size_t end = 0; ///< index of its end
  double s_on_parent = 0;
  double s_outside = 0; ///< where its axis leaves the parent's inscribed tube
  Axis axis;
  std::vector<double> s, radius, curvature, torsion; ///< sampled evenly, ends included
  std::vector<Vec3> x;

  double radius_at(double s) const; ///< maximal inscribed radius, mm
};

struct NearestAxis {
  std::size_t branch;
  std::size_t sample;
  double distance;
};

/// The branches, main first. main is the longest path; the others are ordered by the path length at which they leave.
/// The `ends` get their names (inlet, outlet1, ...), their `branch`, and a `region` in this order. The caller must
/// change the mesh's tags.
/// @param step spacing of the samples along the axes, mm
/// @param wanted branch id of each end (the inlet's is ignored), or empty for that order
/// Throws ComputationError if a path cannot be smoothed.
std::vector<Branch> build_tree(const std::vector<Path>& paths, std::vector<End>& ends, std::size_t inlet,
                               const WallTree& wall, double step, const std::vector<int>& wanted);

/// The branch to whose inscribed tube p is nearest (least d^2 - R^2, VMTK's tube function) and its nearest sample.
NearestAxis nearest_axis(const std::vector<Branch>& branches, const Vec3& p);

} // namespace anatomy
