// Checks that a lumen's triangles are one oriented surface, before any computation on them.
#pragma once
#include "vci/geometry/lumen.hpp"

#include <string>

namespace vci {

/// Points round an open end of the wall, in the order of its triangles' edges.
using Rim = std::vector<int>;

/// The rims of a lumen's wall, which is the surface without its caps. Throws common::InputError, which names `file` and
/// the triangle or point, for any of these faults:
/// - points coincide;
/// - triangles have no area or are given twice;
/// - more than two triangles meet in an edge;
/// - neighbouring triangles face opposite sides;
/// - two rims touch, or the surface has several pieces.
std::vector<Rim> checked_rims(const Lumen& lumen, const std::string& file);

/// Places for error messages: "FILE: triangle 7 at (x, y, z) mm" with the triangle's centroid, "FILE: point 7 at ...".
std::string triangle_location(const Lumen& lumen, std::size_t triangle, const std::string& file);
std::string point_location(const Lumen& lumen, int point, const std::string& file);

} // namespace vci
