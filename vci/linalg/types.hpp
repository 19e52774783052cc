// Shared types. Units inside the engine: mm, g, ms, hence N (g mm/ms^2) and MPa (N/mm^2).
#pragma once
#include <Eigen/Core>
#include <array>
#include <numbers>
#include <vector>

namespace vci {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat2 = Eigen::Matrix2d;
using Mat3 = Eigen::Matrix3d;
using Vectors = std::vector<Vec3>;   ///< points or vectors, mostly one for each vertex of the system
using Triangle = std::array<int, 3>; ///< indices of its corners
using Triangles = std::vector<Triangle>;

using std::numbers::pi;
constexpr double mpa_per_bar = 0.1;
constexpr double mpa_per_pa = 1e-6;

} // namespace vci
