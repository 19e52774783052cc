// Checks that a lumen's triangles are one oriented surface, before any computation on them.
#pragma once
#include "vci/geometry/lumen.hpp"

#include <string>

namespace vci {

/// Points round an open end of the wall, in the order of its triangles' edges.
using Rim = std::vector<int>;

/// The rims of the wall (its triangles without the caps) of a lumen whose triangles form one oriented surface in one
/// piece. Throws common::InputError, which names `file` and the triangle or point, for any of these faults:
/// - points coincide;
/// - triangles have no area or are given twice;
/// - edges have three triangles;
/// - neighbours are turned against one another;
/// - rims touch, or the wall has several pieces.
std::vector<Rim> rims_of_sound_surface(const Lumen& lumen, const std::string& file);

/// "FILE: triangle 7 at (x, y, z) mm", its centroid; and the same of a point.
std::string place_of_triangle(const Lumen& lumen, std::size_t triangle, const std::string& file);
std::string place_of_point(const Lumen& lumen, int point, const std::string& file);

} // namespace vci
