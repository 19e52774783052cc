// Finds an aorta in a lumen, and the coronary trees that arise from it.
#pragma once
#include "ends/plane_cut.hpp"
#include "trees/trunk.hpp"

namespace anatomy {

/// A coronary tree that arises from an aorta.
struct CoronaryTree {
  std::string name;    ///< left or right if that is certain; else tree1, tree2, ... by falling length
  Plane ostium;        ///< across the tree's first stretch; the normal points into the tree
  double diameter = 0; ///< mm, of a disc with the ostium's area; 0 if no plane across the tree was found
  double length = 0;   ///< mm from the aorta to its farthest place
  Offshoot offshoot;
};

struct Aorta {
  double diameter = 0; ///< mm, of its largest ball
  Vec3 centre = Vec3::Zero();
  std::size_t ends = 0;            ///< of its own: open or flat, and as wide as a trunk
  std::vector<CoronaryTree> trees; ///< left and right first, or the longest first
  std::vector<End> stray;          ///< other ends of coronary size, as of a tree cut off just behind its ostium
  std::vector<Vec3> lost;          ///< mm, tips of vessels on the surface that cannot be reached through the lumen
  std::string unnamed_since;       ///< why left and right are not certain; empty if they are

  /// Whether it is an aorta without the user's statement: wider than coronary arteries become, with an end of its own.
  bool is_evident(double scale = 1) const;
};

/// The trunk wider than 9 mm and its offshoots of coronary size; nothing if there is no such trunk. Left and right are
/// found by their order round the ascending aorta. Seen from the arch, the shorter way from the right to the left
/// ostium is anticlockwise, in any right-handed frame and pose.
/// @param mesh closed, with its openings tagged
/// @param scale length in the mesh of one anatomical millimetre: 0.1 if a model in cm was declared in mm
std::optional<Aorta> find_aorta(const Mesh& mesh, double scale = 1);

/// A plane across the tree's longest way at the place nearest to p, with the normal into the tree. Nothing if this
/// place is in the aorta or no section surrounds it.
std::optional<Plane> plane_at(const Mesh& mesh, const CoronaryTree& tree, const Vec3& p);

/// Distance from p to the nearest ball's centre of the tree, in radii of that ball.
double radii_from(const CoronaryTree& tree, const Vec3& p);

} // namespace anatomy
