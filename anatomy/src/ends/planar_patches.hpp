// Finds the flat parts of a surface.
#pragma once
#include "core/slices.hpp"

namespace anatomy {

/// Returns the flat patches of the untagged faces. The faces of a patch are connected and within `off_plane` (mm) of a
/// common plane. Each face's normal is within 60 degrees of the plane's. A patch has at least `least_area` (mm2), and
/// patches do not overlap. The mesh must hold no removed faces.
std::vector<std::vector<Face>> planar_patches(const Mesh& mesh, double off_plane, double least_area);

/// The plane through the centroid of some faces, perpendicular to their mean normal, and the faces' size.
struct PatchPlane {
  Vec3 centre = Vec3::Zero(), normal = Vec3::Zero(); ///< centroid (mm); mean normal, unit, outward
  double area = 0;                                   ///< mm2, area projected on the plane
  double width = 0;                                  ///< mm, minor axis of the ellipse with the faces' second moments
  double extent = 0;                                 ///< mm, least extent of the faces over all directions in the plane
  double lowest = 0, highest = 0;                    ///< mm, smallest and largest height of a vertex over the plane
  SectionSize size() const { return {.area = area, .width = extent}; }
};
PatchPlane plane_of(const Mesh& mesh, const std::vector<Face>& faces);

/// The faces of each tag, except the wall's tag 0.
std::map<int, std::vector<Face>> tagged_faces(const Mesh& mesh);

} // namespace anatomy
