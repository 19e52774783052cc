// Points of a fine surface that move with a coarser surface.
#pragma once
#include "vci/linalg/types.hpp"

namespace vci {

/// Points beside a triangle surface, and where they are once the surface is deformed.
///
/// The displacement of a point follows from values and gradients at the corners of the triangle nearest to it:
///   u = sum_i w_i (u_i + G_i (q - x_i) / 2) + (sum_i w_i G_i) (p - q),
/// with the barycentric weights w_i of the nearest point q. G_i is the gradient that fits the displacements of the
/// corner's neighbours best (least squares). Affine motions (shifts, rotations, uniform widening) are reproduced. Along
/// the surface the error is of third order in the edge length.
class CarriedPoints {
public:
  /// @param triangles, undeformed the surface before its deformation, mm
  /// @param points mm
  CarriedPoints(Triangles triangles, Vectors undeformed, Vectors points);

  /// Distance (mm) of each point from the surface before its deformation.
  const std::vector<double>& distances() const { return distances_; }
  /// The points, mm, once the surface's vertices are at `deformed`.
  Vectors displaced_points(const Vectors& deformed) const;
  /// Values at the surface's vertices, interpolated linearly to the points.
  std::vector<double> interpolate(const std::vector<double>& vertex_values) const;

private:
  Triangles triangles_;
  Vectors undeformed_, points_;
  std::vector<int> nearest_triangle_; ///< triangle nearest to each point
  Vectors weights_;                   ///< barycentric weights of the nearest point of that triangle
  std::vector<double> distances_;
};

} // namespace vci
