// The vascular tree: divides the paths into named branches with smooth axes.
#pragma once
#include "centreline/axis.hpp"
#include "centreline/voronoi.hpp"
#include "core/wall_tree.hpp"

namespace anatomy {

struct Branch {
  std::string name;       ///< main, side1, ...
  int id = 0;             ///< 0, 1, ...
  int parent = -1;        ///< index of the branch it leaves; -1 for main
  std::size_t end = 0;    ///< index of the end at which it ends
  double s_on_parent = 0; ///< mm, arc length on the parent's axis at which this branch's axis starts
  double s_outside = 0;   ///< mm, arc length on this branch's axis at which it leaves the parent's inscribed tube
  Axis axis;
  std::vector<double> s, radius, curvature, torsion; ///< at samples, evenly spaced from end to end: mm, mm, 1/mm, 1/mm
  std::vector<Vec3> x;                               ///< mm, position of each sample

  double radius_at(double s) const; ///< mm, inscribed radius at arc length s (mm)
};

/// The sample of an axis that is nearest to a point.
struct NearestAxis {
  std::size_t branch; ///< index of the branch; 0 if only one branch was searched
  std::size_t sample; ///< index in its samples
  double distance;    ///< mm, from the point to the sample
};

/// Builds the branches, main first. main is the longest path; the others are ordered by the path length from the inlet
/// at which they leave. The `ends` get their names (inlet, outlet1, ...), their `branch`, and a `region` in this order.
/// The caller must change the mesh's tags to these.
/// @param inlet index of the inlet in `ends`
/// @param step spacing of the samples along the axes, mm
/// @param wanted branch id of each end (the inlet's is ignored), or empty for the order above
/// Throws InputError if an end lies in the wall of another vessel.
std::vector<Branch> build_tree(const std::vector<Path>& paths, std::vector<End>& ends, std::size_t inlet,
                               const WallTree& wall, double step, const std::vector<int>& wanted);

/// Finds the sample to whose inscribed sphere p is nearest. This sample has the least d^2 - R^2 (VMTK's tube function),
/// with its distance d from p and its inscribed radius R. Samples of a branch inside its parent's tube are left out.
NearestAxis nearest_axis(const std::vector<Branch>& branches, const Vec3& p);
/// The same for one branch alone.
NearestAxis nearest_axis(const Branch& branch, const Vec3& p);

} // namespace anatomy
