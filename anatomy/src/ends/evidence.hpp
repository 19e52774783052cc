// What the vessel behind a flat part of a surface says of it: does it close the tube, or is it a facet of the wall?
#pragma once
#include "core/slices.hpp"
#include "ends/planar_patches.hpp"
#include <memory>

namespace anatomy {

/// Measured at a flat part. An end is about as wide as the largest ball that fits behind it, the section half a radius
/// behind it is like itself, and the wall round it runs along its normal.
struct Evidence {
  double ball = 0;    ///< mm, radius of the largest ball inside the lumen that touches it at its centre
  double section = 0; ///< mm2, of the lumen half a radius behind it; 0 where there is none
  double tilt = 90;   ///< degrees between its normal and the axis of the wall within a radius behind it
};

/// Why a part of this shape and evidence is no end; empty where it is one. On a surface too `rough` for its planes to
/// be found whole it must be about as large as the section: what is left of the cap would become wall, the end too
/// small.
std::string no_end_since(const PatchPlane& plane, const Evidence& evidence, bool rough);

/// Of the diameter of the ball behind it: what is narrower closes no vessel. A vessel that widens by 20 degrees behind
/// its end has .70 and a wide chamfer .8; of lofts a facet has .67 (six corners), .48 (eight) or less.
constexpr double least_width = 0.6;

/// A closed mesh that outlives it, without removed elements.
class Tubes {
public:
  explicit Tubes(const Mesh& mesh);
  /// Section and tilt are measured only where the width does not decide.
  Evidence evidence(const std::vector<Face>& patch, const PatchPlane& plane) const;
  /// Radius (mm) of the largest ball beyond a plane that touches it at `from` and that no part of the surface reaches
  /// into. For this alone the mesh may be open.
  double ball(const Vec3& from, const Vec3& inward) const;

private:
  double tilt(const std::vector<Face>& patch, const PatchPlane& plane) const;

  const Mesh& mesh_;
  struct Trees;
  std::shared_ptr<const Trees> trees_;
};

} // namespace anatomy
