// Whether a lumen has an aorta, and the coronary trees that hang on it.
#pragma once
#include "ends/plane_cut.hpp"
#include "trees/trunk.hpp"

namespace anatomy {

/// A coronary tree that hangs on an aorta.
struct CoronaryTree {
  std::string name;    ///< left or right where that is certain; else tree1, tree2, ... by falling length
  Plane ostium;        ///< across the tree's first stretch; the normal points into the tree
  double diameter = 0; ///< mm, of a disc of the area there; 0 where no plane across it was found
  double length = 0;   ///< mm from the aorta to its farthest place
  Offshoot offshoot;
};

struct Aorta {
  double diameter = 0; ///< mm, of its largest ball
  Vec3 centre = Vec3::Zero();
  std::size_t ends = 0;            ///< of its own: open or flat, and as wide as a trunk
  std::vector<CoronaryTree> trees; ///< left and right first, or the longest first
  std::vector<End> stray;          ///< coronary-sized ends on neither: a tree cut off just behind its ostium
  std::vector<Vec3> lost;          ///< mm, tips of vessels on the surface to which no way leads through the lumen
  std::string unnamed_since;       ///< why left and right are not certain; empty where they are

  /// Whether it is one without anybody's word: wider than coronary arteries become, and cut off across itself.
  bool is_evident(double scale = 1) const;
};

/// The trunk wider than 9 mm and its offshoots of coronary size; none where there is no such trunk. Left and right are
/// told by their order round the ascending aorta. Seen from the arch, the shorter way from the right to the left ostium
/// is anticlockwise, in any right-handed frame and pose.
/// @param mesh closed, with its openings tagged
/// @param scale length in the mesh of one anatomical millimetre: 0.1 where a model in cm was declared in mm
std::optional<Aorta> find_aorta(const Mesh& mesh, double scale = 1);

/// A plane across the tree's longest way at the place nearest to p, with the normal into the tree; none where that
/// place is in the aorta or no section is round it.
std::optional<Plane> plane_at(const Mesh& mesh, const CoronaryTree& tree, const Vec3& p);

/// Distance from p to the nearest ball's centre of the tree, in radii of that ball.
double radii_from(const CoronaryTree& tree, const Vec3& p);

} // namespace anatomy
