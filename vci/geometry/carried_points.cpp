#include "vci/geometry/carried_points.hpp"
#include "vci/geometry/broad_phase.hpp"
#include "vci/geometry/surface.hpp"

#include <Eigen/Dense>
#include <stdexcept>

namespace vci {

namespace {

// Share of the neighbours' second moments that is added in each direction. If the neighbours lie in a plane, the
// gradient across it is then 0. On a wall of 1.5 mm radius with edges of 0.8 mm the moment across is a hundred times
// this share.
constexpr double flat_share = 1e-4;
constexpr double anywhere = 1e6; // mm, the reach of a search for the nearest triangle

/// The gradient of the displacement at each vertex, by least squares over its neighbours.
std::vector<Mat3> gradients(const std::vector<std::vector<int>>& neighbours, const Vectors& before,
                            const Vectors& displacement) {
  std::vector<Mat3> all;
  for (std::size_t v = 0; v < before.size(); ++v) {
    Mat3 moments = Mat3::Zero(), products = Mat3::Zero();
    for (int n : neighbours[v]) {
      const Vec3 away = before[n] - before[v];
      moments += away * away.transpose();
      products += (displacement[n] - displacement[v]) * away.transpose();
    }
    moments += flat_share * moments.trace() * Mat3::Identity();
    // moments are symmetric and positive definite unless the vertex has no neighbour
    all.push_back(neighbours[v].empty() ? Mat3(Mat3::Zero())
                                        : Mat3(moments.llt().solve(products.transpose()).transpose()));
  }
  return all;
}

} // namespace

CarriedPoints::CarriedPoints(Triangles triangles, Vectors before, Vectors points)
    : triangles_(std::move(triangles)), before_(std::move(before)), points_(std::move(points)) {
  if (triangles_.empty())
    throw std::invalid_argument("a surface without triangles carries no points");
  const BroadPhase boxes(triangles_, before_);
  std::vector<NearTriangle> found;
  for (const Vec3& p : points_) {
    boxes.near(p, triangles_, before_, anywhere, 0.0, -1, found);
    const NearTriangle& nearest = found.front(); // the first of those that are equally near
    nearest_.push_back(nearest.triangle);
    weights_.push_back(nearest.weights);
    distance_.push_back(nearest.distance);
  }
}

Vectors CarriedPoints::moved(const Vectors& after) const {
  Vectors displacement;
  for (std::size_t v = 0; v < before_.size(); ++v)
    displacement.push_back(after[v] - before_[v]);
  const std::vector<Mat3> gradient =
      gradients(vertex_neighbours(triangles_, static_cast<int>(before_.size())), before_, displacement);
  Vectors places = points_;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const Triangle& t = triangles_[nearest_[k]];
    Vec3 nearest = Vec3::Zero();
    for (int c = 0; c < 3; ++c)
      nearest += weights_[k][c] * before_[t[c]];
    const Vec3 beside = points_[k] - nearest;
    for (int c = 0; c < 3; ++c)
      places[k] += weights_[k][c] * (displacement[t[c]] + gradient[t[c]] * (0.5 * (nearest - before_[t[c]]) + beside));
  }
  return places;
}

std::vector<double> CarriedPoints::values(const std::vector<double>& at_vertices) const {
  std::vector<double> values;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const Triangle& t = triangles_[nearest_[k]];
    values.push_back(weights_[k].dot(Vec3(at_vertices[t[0]], at_vertices[t[1]], at_vertices[t[2]])));
  }
  return values;
}

} // namespace vci
