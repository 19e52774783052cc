// Decides whether a flat part of a surface is an end of the vessel or a facet of its wall, from the vessel behind it.
#pragma once
#include "core/slices.hpp"
#include "ends/planar_patches.hpp"
#include <memory>

namespace anatomy {

/// What is measured at a flat part to decide whether it is an end. An end is about as wide as the largest sphere that
/// fits behind it. The section half a radius behind it has about the same size. The wall behind it runs along its
/// normal.
struct EndEvidence {
  double sphere_radius = 0; ///< mm, radius of the largest sphere inside the lumen that touches the part at its centre
  SectionSize section;      ///< of the lumen half a radius behind the part
  double tilt = 90;         ///< degrees between the part's normal and the axis of the wall within a radius behind it
};

/// Why a flat part is no end, as text for the user; empty if it is an end. `rough` says that the surface is too rough
/// for one plane to hold a whole cap. Then the part must also have at least 0.8 of the section's size. A smaller part
/// would make the end too small, and the rest of the cap would become wall.
std::string no_end_reason(const PatchPlane& plane, const EndEvidence& evidence, bool rough);

/// Least ratio of an end's width to the diameter of the sphere behind it. It is 0.70 at an end behind which the vessel
/// widens by 20 degrees, and 0.8 at a wide chamfer. A facet of a lofted wall has 0.67 (six corners), 0.48 (eight) or
/// less.
constexpr double least_width = 0.6;

/// Measures the evidence on a closed mesh without removed elements. The mesh must outlive this object.
class VesselProbe {
public:
  explicit VesselProbe(const Mesh& mesh);
  /// The evidence at the flat part `patch` with the plane `plane`. Section and tilt are measured only if the part is
  /// wide enough for an end.
  EndEvidence evidence(const std::vector<Face>& patch, const PatchPlane& plane) const;
  /// Radius (mm) of the largest sphere that no part of the surface reaches into. The sphere touches a plane at the
  /// point `from`, on the side of the plane's unit normal `inward`. This function also takes an open mesh.
  double sphere_radius(const Vec3& from, const Vec3& inward) const;

private:
  double tilt(const std::vector<Face>& patch, const PatchPlane& plane) const;

  const Mesh& mesh_;
  struct SearchTrees;
  std::shared_ptr<const SearchTrees> search_trees_;
};

} // namespace anatomy
