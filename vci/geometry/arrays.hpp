// Conversion between the engine's vectors and the N x 3 arrays of points and triangles that other libraries use.
#pragma once
#include "vci/geometry/lumen.hpp"

namespace vci {

using PointRows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>; ///< one point in each row, mm
using TriangleRows = Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor>; ///< in each row a triangle's point indices

Vectors vectors_of(const Eigen::Ref<const PointRows>& points);
PointRows rows_of(const Vectors& points);

/// Makes a lumen without caps from arrays.
/// @param triangles triangles of the wall; seen from outside their points run counterclockwise
/// @param radius local radius of the lumen at each point, mm
/// @param plaque thickness of the plaque at each point, mm; empty: no plaque
/// @param plaque_type type of the plaque at each point: 0 none, 1 fibrous, 2 lipid, 3 calcified; empty: 0 everywhere
/// @param reference_radius radius without disease at each point, mm; empty: not known
/// @param branch number of each triangle's branch; empty: all belong to one branch
/// Throws common::InputError for arrays of different lengths, a triangle that names a missing point, a value that is
/// not finite, or an unknown plaque type.
Lumen lumen_from(const Eigen::Ref<const PointRows>& points, const Eigen::Ref<const TriangleRows>& triangles,
                 const std::vector<double>& radius, const std::vector<double>& plaque = {},
                 const std::vector<int>& plaque_type = {}, const std::vector<double>& reference_radius = {},
                 const std::vector<int>& branch = {});

} // namespace vci
