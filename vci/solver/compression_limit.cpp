#include "vci/solver/compression_limit.hpp"

#include <cmath>
#include <limits>

namespace vci {

namespace {

/// The square of the smallest stretch of a triangle between two states. Each state is given by the same two edges (mm).
/// The result is the smaller root l of det(G_after - l G_before) = 0, with G the matrix of the edges' inner products.
/// It is 0 if the triangle turned by more than a right angle, since it may have lost its area on the way. It is
/// infinite for a triangle without area at the start, for which no stretch is defined.
double smallest_squared_stretch(const Vec3& a, const Vec3& b, const Vec3& a_after, const Vec3& b_after) {
  const Vec3 normal = a.cross(b), normal_after = a_after.cross(b_after);
  const double determinant = normal.squaredNorm(), product = normal_after.squaredNorm() / determinant;
  if (!(determinant > 0))
    return std::numeric_limits<double>::infinity();
  if (normal.dot(normal_after) <= 0)
    return 0;
  const double mean = 0.5 *
                      (a_after.squaredNorm() * b.squaredNorm() + b_after.squaredNorm() * a.squaredNorm() -
                       2 * a_after.dot(b_after) * a.dot(b)) /
                      determinant;
  // The smaller root is the product of both roots over the larger one. A difference would lose digits.
  return product / (mean + std::sqrt(std::max(0.0, mean * mean - product)));
}

} // namespace

int limit_compression(const System& system, Vectors& dx) {
  constexpr double least = least_step_stretch * least_step_stretch;
  int held_back = 0;
  for (int k = 0; k < system.bodies(); ++k)
    for (const Triangle& t : system.body(k).triangles) {
      const Vec3 a = system.x[t[1]] - system.x[t[0]], b = system.x[t[2]] - system.x[t[0]];
      const Vec3 da = dx[t[1]] - dx[t[0]], db = dx[t[2]] - dx[t[0]];
      double share = 1;
      while (smallest_squared_stretch(a, b, a + share * da, b + share * db) < least)
        share *= 0.5;
      if (share == 1)
        continue;
      ++held_back;
      const bool supported = system.fixed[t[0]] || system.fixed[t[1]] || system.fixed[t[2]];
      const Vec3 mean = supported ? Vec3(Vec3::Zero()) : Vec3((dx[t[0]] + dx[t[1]] + dx[t[2]]) / 3);
      for (int v : t)
        dx[v] = mean + share * (dx[v] - mean);
    }
  return held_back;
}

} // namespace vci
