// Whether a flat part of a surface closes the vessel or is a facet of its wall, judged by the vessel behind it.
#pragma once
#include "core/slices.hpp"
#include "ends/planar_patches.hpp"
#include <memory>

namespace anatomy {

/// Measured at a flat part. An end is about as wide as the largest ball that fits behind it. The section half a radius
/// behind it is of about its size, and the wall round it runs along its normal.
struct Evidence {
  double ball = 0;    ///< mm, radius of the largest ball inside the lumen that touches it at its centre
  double section = 0; ///< mm2, of the lumen half a radius behind it; 0 where there is none
  double tilt = 90;   ///< degrees between its normal and the axis of the wall within a radius behind it
};

/// Why a part of this shape and evidence is no end; empty if it is one. On a surface too `rough` for whole planes to be
/// found, the part must also be about as large as the section. Otherwise the rest of the cap would become wall, and the
/// end too small.
std::string no_end_since(const PatchPlane& plane, const Evidence& evidence, bool rough);

/// Least width of an end over the diameter of the ball behind it. A vessel that widens by 20 degrees behind its end has
/// .70, a wide chamfer .8. A facet of a lofted wall has .67 (six corners), .48 (eight) or less.
constexpr double least_width = 0.6;

/// Measures a closed mesh without removed elements. The mesh must outlive it.
class Tubes {
public:
  explicit Tubes(const Mesh& mesh);
  /// The evidence at a flat part. Section and tilt are measured only if the part is wide enough for an end.
  Evidence evidence(const std::vector<Face>& patch, const PatchPlane& plane) const;
  /// Radius (mm) of the largest empty ball that touches a plane at `from`, on the side of its unit normal `inward`. No
  /// part of the surface reaches into it. This function also takes an open mesh.
  double ball(const Vec3& from, const Vec3& inward) const;

private:
  double tilt(const std::vector<Face>& patch, const PatchPlane& plane) const;

  const Mesh& mesh_;
  struct Trees;
  std::shared_ptr<const Trees> trees_;
};

} // namespace anatomy
