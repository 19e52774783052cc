// A path through the inscribed spheres, and the direction of the vessel along it.
#pragma once
#include "centreline/inscribed_spheres.hpp"

namespace anatomy {

/// The cheapest path from one sphere back to the sphere at which all `cheapest` paths start. Its points are the centres
/// of the spheres, and `s` is the arc length along them.
struct SpherePath {
  std::vector<std::size_t> spheres; ///< indices of the spheres on the path
  std::vector<Vec3> points;         ///< mm
  std::vector<double> radius, s;    ///< mm: each sphere's radius, and its arc length from the first point

  SpherePath() = default;
  SpherePath(const InscribedSpheres& spheres, const ShortestPaths& cheapest, std::size_t sphere);
  double length() const { return s.back(); }
  /// Index of the first point whose arc length is at least `where` (mm), or of the last point.
  std::size_t index_at(double where) const;
  /// Mean (mm) of the spheres' centres within a quarter of a radius of `where` (mm), since single centres scatter about
  /// the axis.
  Vec3 centre(double where) const;
};

/// Unit direction of the vessel at `where` (mm) on the path. It is the direction most nearly perpendicular to the
/// wall's normals round that place. The path's own direction would scatter by more than a degree, since the spheres'
/// centres scatter. So the path's direction is used only where the two differ by more than 30 degrees, for example
/// where a side branch leaves.
Vec3 vessel_direction(const Mesh& mesh, const SpherePath& path, double where);

} // namespace anatomy
