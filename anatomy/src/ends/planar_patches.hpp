// The flat parts of a surface.
#pragma once
#include "core/types.hpp"

namespace anatomy {

/// Connected untagged faces within `off_plane` (mm) of their least-squares plane, that face outwards of it by less than
/// 60 degrees and have at least `least_area` (mm2) together. They do not overlap. Faces of the mesh count on from zero.
std::vector<std::vector<Face>> planar_patches(const Mesh& mesh, double off_plane, double least_area);

/// A plane through faces: the mean of their area, its direction and its spread.
struct PatchPlane {
  Vec3 centre = Vec3::Zero(), normal = Vec3::Zero(); ///< mm; unit, outward
  double area = 0;                                   ///< mm2, seen along the normal
  double width = 0;                                  ///< mm: the minor axis of the ellipse with their second moments
  double lowest = 0, highest = 0;                    ///< mm, of their vertices over the plane
};
PatchPlane plane_of(const Mesh& mesh, const std::vector<Face>& faces);

/// The faces of each tag but that of the wall (0).
std::map<int, std::vector<Face>> tagged_faces(const Mesh& mesh);

} // namespace anatomy
