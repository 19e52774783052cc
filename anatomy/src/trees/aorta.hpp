// Finds an aorta in a lumen, and the coronary trees that arise from it.
#pragma once
#include "ends/plane_cut.hpp"
#include "trees/trunk.hpp"

namespace anatomy {

/// A coronary tree that arises from an aorta.
struct CoronaryTree {
  std::string name;    ///< left or right if that is certain; else tree1, tree2, ... by falling length
  Plane ostium;        ///< plane across the tree's first stretch; the normal points into the tree
  double diameter = 0; ///< mm, of a disc with the ostium's area; 0 if no plane across the tree was found
  double length = 0;   ///< mm from the aorta to the tree's farthest place
  Offshoot offshoot;
};

struct Aorta {
  double diameter = 0;             ///< mm, of its largest inscribed sphere
  Vec3 centre = Vec3::Zero();      ///< mm, centre of that sphere
  std::size_t ends = 0;            ///< number of its own ends: open or flat, and wider than 9 mm
  std::vector<CoronaryTree> trees; ///< left before right if they are certain, else the longest first
  std::vector<End> stray_ends;     ///< ends of coronary size on no tree: a tree may be cut off just behind its ostium
  std::vector<Vec3> lost_tips;     ///< mm, tips of vessels on the surface that no inscribed spheres lead to
  std::string unnamed_reason;      ///< why left and right are not certain; empty if they are

  /// Whether this is certainly an aorta, even if the user does not say so. It has a coronary tree, and is wider than 12
  /// mm with two ends of its own, or wider than 18 mm with one. `scale` as in find_aorta().
  bool is_evident(double scale = 1) const;
};

/// The trunk wider than 9 mm with the trees of coronary size that leave it; nothing if there is no such trunk. Left and
/// right are told by the order of the ostia round the ascending aorta. Seen from the arch, the shorter way from the
/// right to the left ostium is anticlockwise, in any right-handed frame and pose.
/// @param mesh closed, with its openings tagged
/// @param scale length in the mesh of one anatomical millimetre: 0.1 if a model in cm was declared in mm
std::optional<Aorta> find_aorta(const Mesh& mesh, double scale = 1);

/// The plane across the tree's longest path at the place nearest to p (mm). Its normal points into the tree. Nothing if
/// this place is in the aorta or no section surrounds it.
std::optional<Plane> plane_across_tree(const Mesh& mesh, const CoronaryTree& tree, const Vec3& p);

/// Least distance from p (mm) to the centre of one of the tree's inscribed spheres, in radii of that sphere.
double distance_in_radii(const CoronaryTree& tree, const Vec3& p);

} // namespace anatomy
