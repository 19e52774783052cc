// Where a vertex meets a surface.
#pragma once
#include "vci/mechanics/system.hpp"

namespace vci {

struct Foot {
  int triangle = -1;
  Vec3 weights = Vec3::Zero();
  double distance_squared = 1e300;
};

/// @param units unit normals of the vertices
Vec3 interpolated_normal(const Triangle& t, const Vec3& weights, const Vectors& units);

/// The foot on the triangle where it was last, if it still lies there and near: following it saves the search among
/// all candidates.
bool follow_foot(const Vec3& p, int triangle, const System& system, const Vectors& units, const Body& target,
                 Foot& foot);

/// Where a vertex meets a surface: along the interpolated normal if some triangle near has such a point, else the
/// closest.
/// @param distance takes that of the closest point, mm
Foot foot_of(const Vec3& p, const std::vector<int>& candidates, const System& system, const Vectors& units,
             const Body& target, double& distance);

} // namespace vci
