#include "centreline/ball_way.hpp"
#include <algorithm>

namespace anatomy {
namespace {

constexpr double band = 0.6; // radii before and behind a place: the wall in this band gives the direction
// Radii from the place: includes the wall of oval vessels, but not of neighbouring ones.
constexpr double wall_reach = 2;
// Cosine of the largest angle, 30 degrees, between the two directions in direction_of.
constexpr double cos_agree = 0.87;

} // namespace

BallWay::BallWay(const Balls& all, const Ways& ways, std::size_t ball) {
  for (std::size_t at = ball, last = all.centre.size(); at != last; at = ways.before[at]) {
    last = at;
    s.push_back(points.empty() ? 0 : s.back() + (all.centre[at] - points.back()).norm());
    balls.push_back(at);
    points.push_back(all.centre[at]);
    radius.push_back(all.radius[at]);
  }
}

std::size_t BallWay::at(double where) const {
  const auto above = std::lower_bound(s.begin(), s.end(), where);
  return std::min(static_cast<std::size_t>(above - s.begin()), s.size() - 1);
}

Vec3 BallWay::centre(double where) const {
  const double width = 0.25 * radius[at(where)];
  Vec3 sum = Vec3::Zero();
  int n = 0;
  for (std::size_t i = 0; i < s.size(); ++i)
    if (std::abs(s[i] - where) <= width) {
      sum += points[i];
      ++n;
    }
  return n > 0 ? Vec3(sum / n) : points[at(where)];
}

Vec3 direction_of(const Mesh& mesh, const BallWay& way, double where) {
  const double r = way.radius[way.at(where)];
  const Vec3 centre = way.centre(where);
  const Vec3 along =
      (way.centre(std::min(where + r, way.length())) - way.centre(std::max(where - 0.5 * r, 0.0))).normalized();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (Face f : mesh.faces()) {
    const Halfedge h = mesh.halfedge(f);
    const Vec3 a = vec(mesh.point(mesh.source(h))), b = vec(mesh.point(mesh.target(h))),
               c = vec(mesh.point(mesh.target(mesh.next(h))));
    const Vec3 p = (a + b + c) / 3 - centre, area = (b - a).cross(Vec3(c - a));
    if (std::abs(p.dot(along)) < band * r && p.norm() < wall_reach * r && area.norm() > 0)
      spread += area * area.transpose() / area.norm();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  Vec3 normal = axes.eigenvectors().col(0);
  if (normal.dot(along) < 0)
    normal = -normal;
  return normal.dot(along) > cos_agree ? normal : along;
}

} // namespace anatomy
