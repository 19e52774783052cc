// Conversion between the engine's vectors and N x 3 arrays of points and triangles, as other libraries have them.
#pragma once
#include "vci/geometry/lumen.hpp"

namespace vci {

using PointRows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>; ///< a point a row, mm
using TriangleRows = Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor>; ///< a triangle a row: indices of points

Vectors vectors_of(const Eigen::Ref<const PointRows>& points);
PointRows rows_of(const Vectors& points);

/// A lumen without caps from arrays.
/// @param triangles outward, as seen from outside counterclockwise
/// @param radius local radius of the lumen at each point, mm
/// @param plaque thickness at each point, mm; empty: none
/// @param plaque_type at each point: 0 none, 1 fibrous, 2 lipid, 3 calcified; empty: none
/// @param reference_radius radius without disease at each point, mm; empty: not known
/// Throws common::InputError for arrays of different lengths, a triangle that names a missing point, a value that is
/// not finite, or an unknown plaque type.
Lumen lumen_from(const Eigen::Ref<const PointRows>& points, const Eigen::Ref<const TriangleRows>& triangles,
                 const std::vector<double>& radius, const std::vector<double>& plaque = {},
                 const std::vector<int>& plaque_type = {}, const std::vector<double>& reference_radius = {});

} // namespace vci
